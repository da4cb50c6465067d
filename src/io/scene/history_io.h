// SPDX-License-Identifier: Apache-2.0
// Undo history saved beside a scene: docs/scene-format.md, "Undo history".
#pragma once
#include <cstddef>
#include <filesystem>

#include "session/undo_history.h"

namespace simplexseg {

class AtomicFile;
class Volume;

/// Default limit for the arrays of a saved history, bytes. Steps that exceed it, the farthest from the present, are
/// omitted.
inline constexpr std::size_t kMaxHistoryBytes = std::size_t{128} << 20;

/// Path of the history of a scene: NAME.history for NAME.json.
std::filesystem::path history_path(const std::filesystem::path& scene_file);

/// Writes the steps of `history` nearest to the present, with arrays of about `max_bytes` bytes at most. `scene`: the
/// present scene, as saved in `scene_file`; ids are replaced by those that the scene gets when it is read again. Throws
/// Error for a failed write or a name that is not UTF-8.
void write_history(AtomicFile& file, const std::filesystem::path& scene_file, const Scene& scene,
                   const UndoHistory& history, std::size_t max_bytes = kMaxHistoryBytes);

/// Reads the history beside a scene; an empty history if there is no file. `volume`: volume of the scene. Throws Error
/// if the file is damaged or belongs to another scene or volume; the scene can be opened without its history.
UndoHistory read_history(const std::filesystem::path& scene_file, const Scene& scene, const Volume& volume);

/// Deletes the history file of a scene, but not a file of another format with the same name.
void remove_history(const std::filesystem::path& scene_file);

}  // namespace simplexseg
