// SPDX-License-Identifier: Apache-2.0
#include "evidence/parallel/geodesic.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "ellipsoid_scene.h"
#include "evidence/box_image.h"

namespace simplexseg {
namespace {

TEST(ParallelGeodesic, EqualsTheConvergedCpuDistances) {
  const Scene scene = ellipsoid(36, 2, {13, 11, 9}, 25);
  const BoxImage image = cut_out(scene.image, kVoxelCells, {{0, 0, 0}, scene.image.geometry().size}, run_in_turn());
  const std::array<double, 3> spacing_mm{1, 1, 2};
  const EdgeCost changes{0.02f, 0}, edges{0.002f, 0.06f};
  std::vector<float> start(image.value.size(), 1e4f);
  start[(9 * 36 + 18) * 36 + 18] = 0;
  std::vector<float> by_changes = start, by_edges = start, to_by_changes = start, to_by_edges = start;
  lower_geodesic_distance(by_changes, image.value, image.grid, spacing_mm, changes, 1000);
  lower_geodesic_distance(by_edges, image.value, image.grid, spacing_mm, edges, 1000);
  const SerialExecutor executor;
  ParallelGeodesic<SerialExecutor> geodesic(executor, image.grid, spacing_mm, image.value.data());
  const ParallelGeodesic<SerialExecutor>::Distance both[]{{to_by_changes.data(), changes}, {to_by_edges.data(), edges}};
  geodesic.begin(both);
  geodesic.finish();
  for (std::size_t v = 0; v < start.size(); ++v) {
    ASSERT_NEAR(to_by_changes[v], by_changes[v], 1e-5f) << v;
    ASSERT_NEAR(to_by_edges[v], by_edges[v], 1e-5f) << v;
  }
  EXPECT_GT(by_edges.front(), 1);
}

}  // namespace
}  // namespace simplexseg
