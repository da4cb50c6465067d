// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <vector>

#include "session/scene.h"
#include "step/engine.h"

namespace simplexseg {

class Volume;

/// Meshes and attraction points to load into an engine. The spans refer to arrays of the scene, which must outlive this
/// object.
struct EngineScene {
  std::vector<EngineMesh> meshes;
  std::vector<EnginePoint> points;
};
EngineScene engine_scene(const Scene& scene, const Volume& volume);
/// Field of a mesh for the engine, which shares its values; without values if the mesh has none.
EngineField engine_field(const MeshItem& item);
/// Attraction points of the engine: the boundary points of the scene.
std::vector<EnginePoint> engine_points(const Scene& scene);

}  // namespace simplexseg
