// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "session/scene.h"
#include "step/engine.h"

namespace simplexseg {

class Volume;

/// A scene as an engine is loaded with it; refers to the scene.
struct EngineScene {
  std::vector<EngineMesh> meshes;
  std::vector<EnginePoint> points;
};
EngineScene engine_scene(const Scene& scene, const Volume& volume);
/// The points that attract meshes.
std::vector<EnginePoint> engine_points(const Scene& scene);

}  // namespace simplexseg
