// SPDX-License-Identifier: Apache-2.0
#include "session/step_messages.h"

#include <sstream>

#include "forces/force_list.h"

namespace simplexseg {

std::string text_of(const StepFailure& failure, const Scene& scene) {
  const std::string start =
      "mesh '" + scene.meshes[failure.mesh].name + "': force " + force_list()[static_cast<int>(failure.force)].name;
  switch (failure.what) {
    case StepFailure::What::Folded:
      return start + " folds its surface";
    case StepFailure::What::Grew:
      return start + " makes it oscillate more and more";
    default:
      return start + " drove vertex " + std::to_string(failure.vertex) + " out of the scene";
  }
}

std::string text_of(const TimestepCut& cut, const Scene& scene) {
  std::ostringstream line;
  line << text_of(cut.failure, scene) << "; the steps were undone, and its timestep is " << cut.factor
       << " of what it was";
  return line.str();
}

}  // namespace simplexseg
