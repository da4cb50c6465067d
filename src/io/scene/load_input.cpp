// SPDX-License-Identifier: Apache-2.0
#include "io/scene/load_input.h"

#include <algorithm>
#include <span>

#include "core/error.h"
#include "io/platform/files.h"
#include "io/registration/filters.h"
#include "io/scene/history_io.h"
#include "io/scene/set_by_path.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"
#include "session/session.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// Result of filters on the volume; new results are added to those of the input, which contain the volume without
/// filters.
const Volume& filtered_volume(LoadedInput& input, const std::vector<FilterStep>& filters) {
  const auto find = [&](std::span<const FilterStep> some) -> const Volume* {
    for (const FilteredVolume& one : input.volumes)
      if (std::ranges::equal(one.filters, some)) return &one.volume;
    return nullptr;
  };
  const auto add = [&](std::span<const FilterStep> some, Volume result) {
    input.volumes.push_back({{some.begin(), some.end()}, std::move(result)});
  };
  return apply_filters(filters, find, add,
                       [](const Volume& volume, const FilterStep& step) { return filter_volume(volume, step); });
}

/// Applies the filters of the scene to its volume.
void filter_loaded_volume(LoadedInput& input) {
  const Preprocessing& preprocessing = input.scene.volume_preprocessing;
  if (preprocessing.filters.empty()) return;
  check_volume_filters(preprocessing);
  input.volumes.push_back({{}, input.volume});
  input.volume = filtered_volume(input, preprocessing.filters);
  if (!preprocessing.checksum.empty() && checksum_of(input.volume) != preprocessing.checksum)
    input.warnings.push_back("the filters of " + quoted(input.volume_path) +
                             " give other values than those with which the scene was saved, because the image or the "
                             "version of ITK differs: check that the segmentations are right");
}

/// Loads the volume of a scene. Returns its uptake values, if it is a PET series.
UptakeScale load_voxels(LoadedInput& input) {
  LoadedVolume loaded = load_volume(input.volume_path, input.scene.volume_number, input.scene.volume_series);
  input.volume = std::move(loaded.volume);
  input.patient = std::move(loaded.patient);
  input.series = std::move(loaded.series);
  input.intensity_unit = std::move(loaded.intensity_unit);
  input.warnings = std::move(loaded.warnings);
  input.is_dicom = loaded.is_dicom;
  input.low_is_bright = loaded.low_is_bright;
  const std::string checksum = checksum_of(input.volume);
  std::string& expected = input.scene.volume_checksum;
  if (!expected.empty() && expected != checksum)
    input.warnings.insert(input.warnings.begin(),
                          quoted(input.volume_path) +
                              " is not the image with which the scene was saved: check that the segmentations are in "
                              "the right place");
  expected = checksum;
  filter_loaded_volume(input);
  return loaded.uptake;
}

void load_header(LoadedInput& input) {
  VolumeInfo info = read_volume_info(input.volume_path, input.scene.volume_number, input.scene.volume_series);
  input.volume = Volume(info.geometry, type_after(input.scene.volume_preprocessing.filters, info.type));
  input.warnings = std::move(info.warnings);
}

void load_references(LoadedInput& input, const fs::path& folder, LoadOptions::BadReference bad_reference) {
  try {
    input.references = References(input.scene, folder, input.volume.geometry());
    const std::vector<std::string>& warnings = input.references.warnings();
    input.warnings.insert(input.warnings.end(), warnings.begin(), warnings.end());
  } catch (const Error& error) {
    if (bad_reference == LoadOptions::BadReference::Throw) throw;
    input.warnings.emplace_back(error.what());
  }
}

/// Loads the references of meshes that undo or redo would restore.
void load_references_of_history(LoadedInput& input, const fs::path& folder) {
  Scene others;
  const auto is_known = [&input](const MeshItem& item) {  // loaded, or reported as missing
    return std::any_of(input.scene.meshes.begin(), input.scene.meshes.end(), [&item](const MeshItem& other) {
      return other.reference && other.reference->labels == item.reference->labels;
    });
  };
  for (const UndoHistory::Entries* entries : {&input.history.to_undo(), &input.history.to_redo()})
    for (const auto& entry : *entries)
      for (const MeshItem& item : entry->scene.without_arrays().meshes)
        if (item.reference && !is_known(item)) others.meshes.push_back(item);
  const References found(others, folder, input.volume.geometry());
  input.references.add(found);
  input.warnings.insert(input.warnings.end(), found.warnings().begin(), found.warnings().end());
}

/// Loads the files of the layers of the scene, and of those that undo or redo would restore.
void load_layers(LoadedInput& input, const fs::path& folder) {
  input.layers.load(input.scene, folder, input.warnings);
  Scene others;
  for (const UndoHistory::Entries* entries : {&input.history.to_undo(), &input.history.to_redo()})
    for (const auto& entry : *entries)
      for (const LayerItem& layer : entry->scene.without_arrays().layers) {
        const auto uses_same_files = [&layer](const LayerItem& other) {
          return layer.path == other.path && layer.number == other.number && layer.series == other.series &&
                 layer.preprocessing == other.preprocessing && layer.transform.file == other.transform.file;
        };
        if (std::none_of(input.scene.layers.begin(), input.scene.layers.end(), uses_same_files) &&
            std::none_of(others.layers.begin(), others.layers.end(), uses_same_files))
          others.layers.push_back(layer);
      }
  input.layers.load(others, folder, input.warnings);
}

/// Applies the filters of the volume that undo or redo would restore.
void filter_volumes_of_history(LoadedInput& input) {
  for (const UndoHistory::Entries* entries : {&input.history.to_undo(), &input.history.to_redo()})
    for (const auto& entry : *entries) {
      const std::vector<FilterStep>& filters = entry->scene.without_arrays().volume_preprocessing.filters;
      if (filters == input.scene.volume_preprocessing.filters) continue;
      if (input.volumes.empty()) input.volumes.push_back({{}, input.volume});
      filtered_volume(input, filters);
    }
}

/// Loads the undo history. An error only adds a warning, since the scene is complete without a history.
void load_history(LoadedInput& input, const fs::path& path) {
  try {
    input.history = read_history(path, input.scene, input.volume);
    load_references_of_history(input, path.parent_path());
  } catch (const Error& error) {
    input.warnings.emplace_back(error.what());
  }
}

}  // namespace

LoadedInput load_scene(const fs::path& path, const LoadOptions& options) {
  LoadedInput input = load_scene(read_scene(path), path.parent_path(), options);
  if (options.history == LoadOptions::History::Read) load_history(input, path);
  if (options.layers == LoadOptions::Layers::Read) {
    load_layers(input, path.parent_path());
    try {
      filter_volumes_of_history(input);
    } catch (const Error& error) {
      input.warnings.push_back(std::string("undo of filters is not possible: ") + error.what());
    }
  }
  return input;
}

LoadedInput load_scene(SceneFile file, const fs::path& folder, const LoadOptions& options) {
  for (const std::string& setting : options.settings) set_by_path(file.scene, setting);
  if (options.check) options.check(file);
  LoadedInput input;
  input.scene = std::move(file.scene);
  input.volume_path = std::move(file.volume);
  const bool reads = options.voxels == LoadOptions::Voxels::Read;
  if (!input.volume_path.empty() && reads) load_voxels(input);
  if (!input.volume_path.empty() && !reads) load_header(input);
  input.warnings.insert(input.warnings.end(), file.warnings.begin(), file.warnings.end());
  if (reads) load_references(input, folder, options.bad_reference);
  return input;
}

void add_filters(Session& session, std::vector<FilteredVolume> volumes) {
  for (FilteredVolume& one : volumes) session.add_volume(std::move(one));
  session.set_volume_filter([](const Volume& volume, const FilterStep& step) { return filter_volume(volume, step); });
}

LoadedInput load_input(const fs::path& path, int volume, const std::string& series) {
  if (path.extension() == ".json")
    return load_scene(path, {.bad_reference = LoadOptions::BadReference::Warn,
                             .history = LoadOptions::History::Read,
                             .layers = LoadOptions::Layers::Read});
  LoadedInput input;
  input.scene.volume_path = fs::absolute(path).string();
  input.scene.volume_number = volume;
  input.scene.volume_series = series;
  input.scene.simulation = default_simulation_parameters();
  input.volume_path = path;
  const UptakeScale uptake = load_voxels(input);
  if (uptake.factor > 0) {
    input.scene.volume_preprocessing.filters = {{FilterKind::Uptake, {uptake.factor}}};
    filter_loaded_volume(input);
    input.scene.volume_preprocessing.checksum = checksum_of(input.volume);
  } else if (std::string why = uptake_warning(path, uptake); !why.empty()) {
    input.warnings.push_back(std::move(why));
  }
  return input;
}

}  // namespace simplexseg
