// SPDX-License-Identifier: Apache-2.0
// Drawing into host memory; the same kernels fill the buffers of the window.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "mesh/mesh_geometry.h"
#include "mesh/simplex_mesh.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class DrawingTest : public EngineTest {
 protected:
  /// Scene of two meshes.
  static TestScene two_meshes() {
    TestScene scene = busy_scene(3);
    TestMesh other = scene.meshes[0];
    other.mesh = make_sphere({5, 3, -4}, 9, 2);
    other.shape.clear(), other.profiles.clear();
    scene.meshes.push_back(other);
    weight_of(scene.meshes[0].forces, ForceId::Smoothing) = 0.5f;
    return scene;
  }
};
SIMPLEXSEG_ON_EVERY_BACKEND(DrawingTest);

TEST_P(DrawingTest, SurfacesFollowThePose) {
  const TestScene scene = two_meshes();
  const auto engine = make_engine();
  load(*engine, scene);
  EXPECT_FALSE(engine->has_cells());
  std::vector<DisplayPoint> none;
  EXPECT_THROW(engine->draw_surfaces({nullptr, none}), Error);
  std::vector<CellList> cells{cells_of(scene.meshes[0].mesh), cells_of(scene.meshes[1].mesh)};
  const CellList* const lists[] = {&cells[0], &cells[1]};
  engine->set_cells(lists);
  engine->step(7);
  const std::size_t vertices = scene.meshes[0].mesh.positions.size() + scene.meshes[1].mesh.positions.size();
  std::vector<DisplayPoint> points(vertices + cells[0].count() + cells[1].count());
  EXPECT_THROW(engine->draw_surfaces({nullptr, std::span(points).first(vertices)}), Error);
  engine->draw_surfaces({nullptr, points});
  std::size_t vertex = 0, centre = vertices;
  for (int m = 0; m < 2; ++m) {
    const SimplexMesh mesh = mesh_of(*engine, scene, m);
    for (int i = 0; i < mesh.vertex_count(); ++i, ++vertex) {
      const DisplayPoint& p = points[vertex];
      ASSERT_EQ(Eigen::Vector3f(p.position.x, p.position.y, p.position.z), mesh.positions[i]);
      ASSERT_LT((Eigen::Vector3d(p.normal.x, p.normal.y, p.normal.z) - vertex_geometry(mesh, i).normal).norm(), 1e-4);
    }
    for (int c = 0; c < cells[m].count(); ++c, ++centre) {
      Eigen::Vector3f mean(0, 0, 0);
      for (int corner : cells[m][c]) mean += mesh.positions[corner];
      mean /= static_cast<float>(cells[m][c].size());
      const DisplayPoint& p = points[centre];
      ASSERT_LT((Eigen::Vector3f(p.position.x, p.position.y, p.position.z) - mean).norm(), 1e-4f);
      ASSERT_NEAR(norm(xyz(p.normal)), 1, 1e-4);
    }
  }
}

TEST_P(DrawingTest, OutlinesLieOnThePlaneAndOnTheSurface) {
  TestScene scene = two_meshes();
  scene.meshes[0].mesh = make_sphere({0, 0, 0}, 20, 4);
  scene.meshes[0].shape.clear(), scene.meshes[0].profiles.clear();
  const auto engine = make_engine();
  load(*engine, scene);
  std::vector<CellList> cells{cells_of(scene.meshes[0].mesh), cells_of(scene.meshes[1].mesh)};
  const CellList* const lists[] = {&cells[0], &cells[1]};
  engine->set_cells(lists);
  const std::size_t vertices = scene.meshes[0].mesh.positions.size() + scene.meshes[1].mesh.positions.size();
  std::vector<std::byte> memory(outline_bytes(2, vertices));
  for (int axis = 0; axis < 3; ++axis) {
    const float at = 1.3f;
    engine->draw_outlines(axis, at, {nullptr, memory});
    const auto* commands = reinterpret_cast<const OutlineCommand*>(memory.data());
    const auto* segments = reinterpret_cast<const OutlineSegment*>(memory.data() + 2 * sizeof(OutlineCommand));
    EXPECT_EQ(commands[0].corners, 4u);
    ASSERT_GT(commands[0].segments, 100u);
    ASSERT_GT(commands[1].segments, 10u);
    double length = 0;
    for (std::uint32_t k = 0; k < commands[0].segments; ++k) {
      const OutlineSegment& segment = segments[commands[0].first_segment + k];
      for (const Vec3& end : {segment.start, segment.end}) {
        ASSERT_NEAR(axis == 0 ? end.x : axis == 1 ? end.y : end.z, at, 1e-4);
        ASSERT_NEAR(norm(end), 20, 0.15);
      }
      length += norm(segment.end - segment.start);
    }
    EXPECT_NEAR(length, 2 * M_PI * std::sqrt(400 - at * at), 1) << "the circle is closed";
  }
  engine->draw_outlines(0, 500, {nullptr, memory});
  EXPECT_EQ(reinterpret_cast<const OutlineCommand*>(memory.data())->segments, 0u) << "a distant plane cuts nothing";
}

TEST_P(DrawingTest, SlicesAreTheVoxelsAfterWindowAndLevel) {
  for (const VoxelType type : {VoxelType::Int16, VoxelType::UInt8, VoxelType::Int32, VoxelType::Float32}) {
    PhantomSettings settings;
    settings.size = 24, settings.type = type, settings.noise_sigma = 3;
    TestScene scene;
    scene.volume = make_phantom("sphere", settings).image;
    const auto engine = make_engine();
    load(*engine, scene);
    SlicePlane plane;
    plane.origin = {-2, 0, 7}, plane.step_u = {1, 0, 0}, plane.step_v = {0, 1, 0};
    plane.width = 28, plane.height = 24, plane.low = 20, plane.high = 180;
    std::vector<DisplayTexel> texels(28 * 24);
    engine->draw_slice(plane, {nullptr, texels});
    for (int v = 0; v < 24; ++v)
      for (int u = 0; u < 28; ++u) {
        const DisplayTexel texel = texels[v * 28 + u];
        const bool inside = u >= 2 && u < 26;
        ASSERT_EQ(texel.inside, inside ? 255 : 0) << to_string(type) << " " << u << " " << v;
        if (!inside) continue;
        const double grey = std::clamp((scene.volume.value(u - 2, v, 7) - 20) / 160, 0.0, 1.0);
        ASSERT_NEAR(texel.grey, 255 * grey, 0.51) << to_string(type) << " " << u << " " << v;
      }
    std::swap(plane.low, plane.high);  // like a MONOCHROME1 image
    std::vector<DisplayTexel> inverted(texels.size());
    engine->draw_slice(plane, {nullptr, inverted});
    for (std::size_t t = 0; t < texels.size(); ++t) {
      const int expected = texels[t].inside ? 255 - texels[t].grey : 0;
      ASSERT_NEAR(inverted[t].grey, expected, 1) << to_string(type) << " " << t;
    }
    std::swap(plane.low, plane.high);
    plane.high = 60;
    std::vector<DisplayTexel> harder(texels.size());
    engine->draw_slice(plane, {nullptr, harder});
    EXPECT_GT(std::count_if(harder.begin(), harder.end(), [](DisplayTexel t) { return t.grey == 255; }),
              std::count_if(texels.begin(), texels.end(), [](DisplayTexel t) { return t.grey == 255; }));
  }
}

}  // namespace
}  // namespace simplexseg
