// SPDX-License-Identifier: Apache-2.0
#include "session/step_messages.h"

#include <sstream>

#include "forces/force_list.h"

namespace simplexseg {

std::string text_of(const StepFailure& failure, const Scene& scene) {
  const std::string start = "segmentation '" + scene.meshes[failure.mesh].name + "': force " +
                            force_list()[static_cast<int>(failure.force)].name;
  switch (failure.kind) {
    case StepFailure::Kind::Folded:
      return start + " folds the surface";
    case StepFailure::Kind::Diverged:
      return start + " makes the surface oscillate with growing amplitude";
    default:
      return start + " moved vertex " + std::to_string(failure.vertex) + " out of the scene";
  }
}

std::string text_of(const TimestepCut& cut, const Scene& scene) {
  std::ostringstream line;
  line << text_of(cut.failure, scene) << "; the steps were undone, and its timestep is now " << cut.factor
       << " of the set value";
  return line.str();
}

std::string range_warning(const std::string& name, RangeEffect effect) {
  const std::string start = "The range of intensities of '" + name + "' ";
  switch (effect) {
    case RangeEffect::Limits:
      break;
    case RangeEffect::AllVoxels:
      return start + "contains the whole image and has no effect. Narrow it, or remove its limits.";
    case RangeEffect::NoVoxel:
      return start + "contains nothing of the image: only marks and paint are left. Widen it.";
    case RangeEffect::WithoutSeed:
      return start + "excludes most of the seed. Widen it, or place a seed in tissue of these intensities.";
  }
  return {};
}

}  // namespace simplexseg
