// SPDX-License-Identifier: Apache-2.0
// What a file on disk turns into: one loader for the window and the command line.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/references.h"
#include "io/scene_io.h"
#include "session/scene.h"
#include "session/undo_history.h"

namespace simplexseg {

/// A scene with its volume and the references that its meshes name.
struct LoadedInput {
  Scene scene;
  Volume volume;                      ///< empty when the scene names none
  std::filesystem::path volume_path;  ///< where it was found; empty when the scene names none
  std::string patient, series;        ///< names, of DICOM; empty where it has none
  References references;
  UndoHistory history;                ///< where it was asked for, and the scene has one
  std::vector<std::string> warnings;  ///< one line each, for the user
  bool is_dicom = false;              ///< the volume is made of DICOM images, to which files of DICOM can refer
  bool low_is_bright = false;         ///< the volume's low values are meant to be shown bright (MONOCHROME1)
};

struct LoadOptions {
  enum class Voxels { Read, LeaveOut };
  enum class BadReference { Refuse, Warn };
  enum class History { LeaveOut, Read };

  std::vector<std::string> settings{};  ///< as for set_by_path(), applied before any file but the scene's is read
  /// LeaveOut: the volume has its geometry and type, and zeros; there are no references.
  Voxels voxels = Voxels::Read;
  BadReference bad_reference = BadReference::Refuse;
  /// Read: what could be taken back when the scene was saved; one that cannot be read is a warning.
  History history = History::LeaveOut;
};

/// Reads a scene file, its volume and its references. Throws Error as the readers do; a reference that cannot be read
/// is one too, or a warning, as the options say.
LoadedInput load_scene(const std::filesystem::path& path, const LoadOptions& options = {});
/// The same of a scene that was made, or read already; its references are looked for in `folder`, too. It has no
/// history.
LoadedInput load_scene(SceneFile file, const std::filesystem::path& folder, const LoadOptions& options = {});

/// Reads what a user names to be looked at: a scene (.json), else a volume or a DICOM folder, which makes a scene
/// without meshes (its undo history is read, too); of a 4D file number `volume`, from 1 (a scene names its own); of a
/// DICOM folder the series with the UID `series`; empty: the largest. Throws Error; a reference that cannot be read is
/// a warning.
LoadedInput load_input(const std::filesystem::path& path, int volume = 1, const std::string& series = {});

}  // namespace simplexseg
