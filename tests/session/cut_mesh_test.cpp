// SPDX-License-Identifier: Apache-2.0
// Meshes of objects that the sides of the volume cut.
#include "image/metrics.h"
#include "image/rasterise.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Bright tube of radius 8 mm along the axis of the slices (of `thick` mm) through the whole volume, with noise.
struct Tube {
  Volume image;
  Mask truth;
};
Tube tube(int slices, double thick) {
  VolumeGeometry geometry;
  geometry.size = {40, 40, slices};
  geometry.spacing_mm = {1, 1, thick};
  geometry.origin_mm = {-19.5, -19.5, -0.5 * thick * (slices - 1)};
  Tube tube{Volume(geometry, VoxelType::Float32), {geometry, std::vector<std::uint8_t>(geometry.voxel_count())}};
  std::uint64_t state = 1;
  std::size_t v = 0;
  for (int k = 0; k < slices; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i, ++v) {
        state = state * 6364136223846793005u + 1442695040888963407u;
        const bool in = std::hypot(i - 19.5, j - 19.5) <= 8;
        tube.truth.voxels[v] = in;
        tube.image.voxels<float>()[v] = (in ? 150.0f : 50.0f) + 20 * static_cast<float>((state >> 40) * 0x1p-24 - 0.5);
      }
  return tube;
}

TEST(CutMesh, SettlesOnTheSidesOfTheVolume) {
  constexpr int kSteps = 6000;
  for (const auto& [slices, thick] : {std::pair{26, 1.0}, std::pair{9, 4.0}}) {
    SCOPED_TRACE(slices);
    const Tube object = tube(slices, thick);
    Scene scene;
    scene.simulation = default_simulation_parameters(), scene.forces = default_force_parameters();
    MeshItem tube;
    tube.name = "tube", tube.seed = {{0, 0, 0}, 5}, tube.parameters = scene.forces;
    scene.meshes.push_back(tube);
    Session session(make_cpu_engine(1), {}, 1);
    session.open(scene, object.image);
    const Advance advance = session.advance_steps(kSteps, true);
    EXPECT_TRUE(advance.at_rest) << advance.steps;
    const MeshItem& item = session.scene().meshes[0];
    EXPECT_GE(dice(rasterise(item.mesh, object.image.geometry()), object.truth), 0.97);
    const float face = static_cast<float>(0.5 * thick * slices);
    float lowest = 0, highest = 0;
    for (const Eigen::Vector3f& p : item.mesh.positions)
      lowest = std::min(lowest, p.z()), highest = std::max(highest, p.z());
    EXPECT_NEAR(lowest, -face, 0.6) << "the end lies on the face of the volume";
    EXPECT_NEAR(highest, face, 0.6);
  }
}

}  // namespace
}  // namespace simplexseg
