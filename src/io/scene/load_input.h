// SPDX-License-Identifier: Apache-2.0
// Loads a scene with its volume, references and undo history, or an image, for the window and the command line.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/scene/layer_images.h"
#include "io/scene/references.h"
#include "io/scene/scene_io.h"
#include "session/filtered_volumes.h"
#include "session/scene.h"
#include "session/undo_history.h"

namespace simplexseg {

/// Scene with its volume and the reference segmentations of its meshes.
struct LoadedInput {
  Scene scene;
  Volume volume;  ///< after the filters of the scene; empty if the scene has none
  /// For Session::add_volume(): the volume without filters and other results; empty without filters.
  std::vector<FilteredVolume> volumes;
  std::filesystem::path volume_path;  ///< file of the volume; empty if the scene has none
  std::string patient, series;        ///< DICOM patient name, else patient ID; series description; empty if missing
  std::string intensity_unit;         ///< unit of the voxels without filters, "HU" for CT in DICOM; empty if unknown
  References references;
  LayerImages layers;                 ///< empty unless LoadOptions::layers is Read
  UndoHistory history;                ///< empty unless LoadOptions::history is Read
  std::vector<std::string> warnings;  ///< one line each, for the user
  bool is_dicom = false;              ///< the volume is a DICOM image, so DICOM output can refer to it
  bool low_is_bright = false;         ///< low values are displayed bright (MONOCHROME1)
};

/// Options of load_scene().
struct LoadOptions {
  enum class Voxels { Read, Skip };
  enum class BadReference { Throw, Warn };
  enum class History { Skip, Read };
  enum class Layers { Skip, Read };

  std::vector<std::string> settings{};  ///< assignments for set_by_path(), applied before other files are read
  /// Skip: the volume has its geometry and voxel type, but all voxels are 0; references are not read.
  Voxels voxels = Voxels::Read;
  BadReference bad_reference = BadReference::Throw;
  /// Read: restores the undo history; a history that cannot be read adds a warning.
  History history = History::Skip;
  /// Read: loads the files of layers, also of those in the undo history, and applies the filters of the volume in that
  /// history; one that cannot be read or applied adds a warning.
  Layers layers = Layers::Skip;
  /// Called with the scene and its settings before the volume is read; may throw. Empty: not called.
  std::function<void(const SceneFile&)> check{};
};

/// Reads a scene file, its volume, its references and, if requested, its undo history. Throws the errors of the
/// readers; a reference that cannot be read throws Error or adds a warning, depending on LoadOptions::bad_reference.
LoadedInput load_scene(const std::filesystem::path& path, const LoadOptions& options = {});
/// Loads the volume and the references of a scene that has been read already. References are also searched in `folder`.
/// Ignores LoadOptions::history.
LoadedInput load_scene(SceneFile file, const std::filesystem::path& folder, const LoadOptions& options = {});

class Session;
/// Gives an open session the filters, and LoadedInput::volumes.
void add_filters(Session& session, std::vector<FilteredVolume> volumes);

/// Reads the file that a user opens: a scene (.json) with its undo history, or a volume or DICOM folder, which becomes
/// a scene without meshes; PET in DICOM is filtered to uptake values (FilterKind::Uptake) or adds a warning. `volume`:
/// number of the volume in a 4D file, from 1; `series`: UID of the series in a DICOM folder, empty for the largest
/// series; both are ignored for a scene. Throws the errors of the readers; a reference or history that cannot be read
/// adds a warning.
LoadedInput load_input(const std::filesystem::path& path, int volume = 1, const std::string& series = {});

}  // namespace simplexseg
