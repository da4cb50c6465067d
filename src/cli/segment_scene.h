// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "io/scene_io.h"

namespace simplexseg {

/// What is asked of `segment`, as the command line has it. Positions are texts "X,Y,Z" in mm, LPS.
struct SegmentRequest {
  std::string image, series;
  int volume_number = 1;
  std::string scene;  ///< template; empty: none
  std::vector<std::string> seeds, names;
  std::vector<double> radii;                           ///< one for all seeds or one for each; none: 10 mm
  std::string start_labels;                            ///< that meshes start from instead of seeds
  std::vector<std::string> inside, outside, boundary;  ///< points of the only mesh, or "MESH=X,Y,Z"
  std::string reference;
  std::optional<double> reference_label;
};

/// The scene that it stands for, with the image as its volume. Throws Error where it makes none.
SceneFile segment_scene(const SegmentRequest& request);

}  // namespace simplexseg
