// SPDX-License-Identifier: Apache-2.0
// What can be taken back and done again, kept beside a saved scene: docs/scene-format.md, "Undo history".
#pragma once
#include <cstddef>
#include <filesystem>

#include "session/undo_history.h"

namespace simplexseg {

class AtomicFile;
class Volume;

/// Of arrays that a saved history has at most; steps that are further away are left out.
inline constexpr std::size_t kMostHistoryBytes = std::size_t{128} << 20;

/// NAME.history, for NAME.json.
std::filesystem::path history_path(const std::filesystem::path& scene_file);

/// Writes the steps of `history` that are nearest to the present, in about `most_bytes`. `scene`: the present, as it is
/// written to `scene_file`; ids are those that it has when it is read again. Throws Error for a failed write and for
/// names that are not UTF-8.
void write_history(AtomicFile& file, const std::filesystem::path& scene_file, const Scene& scene,
                   const UndoHistory& history, std::size_t most_bytes = kMostHistoryBytes);

/// The history beside a scene that was just read; empty where there is no file. Throws Error, one line that says that
/// the scene opens without it, where the file is not whole and sound, or belongs to another scene or volume.
UndoHistory read_history(const std::filesystem::path& scene_file, const Scene& scene, const Volume& volume);

/// Removes the file where it is a history.
void remove_history(const std::filesystem::path& scene_file);

}  // namespace simplexseg
