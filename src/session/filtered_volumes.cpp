// SPDX-License-Identifier: Apache-2.0
#include "session/filtered_volumes.h"

#include <utility>

#include "core/error.h"
#include "session/scene_editor.h"

namespace simplexseg {

void FilteredVolumes::open(const std::vector<FilterStep>& filters, const Volume& volume) {
  by_key_.clear();
  by_key_.emplace(key_of(filters), volume);
}

void FilteredVolumes::add(FilteredVolume result) {
  if (!by_key_.empty() && result.volume.geometry().size != by_key_.begin()->second.geometry().size)
    throw Error("the filtered volume", "its grid is not that of the volume of the scene", "filter it again");
  by_key_.insert_or_assign(key_of(result.filters), std::move(result.volume));
}

const Volume& FilteredVolumes::get(const std::vector<FilterStep>& filters) {
  const auto find = [this](std::span<const FilterStep> some) -> const Volume* {
    const auto found = by_key_.find(key_of(some));
    if (found != by_key_.end()) return &found->second;
    if (some.empty()) throw Error("the volume without filters", "it is not loaded", "open the scene again");
    return nullptr;
  };
  const auto apply = [this](const Volume& volume, const FilterStep& step) {
    if (!apply_) throw Error("cannot filter the volume", "this program has no filters", "open it in another program");
    return apply_(volume, step);
  };
  return apply_filters(
      filters, find,
      [this](std::span<const FilterStep> some, Volume volume) {
        add({{some.begin(), some.end()}, std::move(volume)});
      },
      apply);
}

void check_volume_filters(const Preprocessing& preprocessing) {
  check_preprocessing(preprocessing);
  for (const FilterStep& step : preprocessing.filters)
    if (!info_of(step.kind).keeps_grid)
      throw Error(std::string("cannot apply the filter ") + info_of(step.kind).name + " to the volume",
                  "marks, paint and labels have its grid, which would change",
                  "filter the file by 'simplexseg-cli filter' and open the result");
}

SceneChange SceneEditor::execute(const FilterVolume& command) {
  if (volume_.empty()) throw Error("cannot filter the volume", "the scene has none", "open an image first");
  check_volume_filters(command.preprocessing);
  scene_.volume_preprocessing = command.preprocessing;
  for (MeshItem& item : scene_.meshes) item.cancelled = nullptr;  // the fields are solved again
  return {EngineUpdate::Meshes};
}

}  // namespace simplexseg
