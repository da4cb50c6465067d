// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "field/shape_prior.h"

namespace simplexseg {
namespace {

TEST(ShapePrior, IsInterpolatedBetweenGridsAndConstantBeyond) {
  ShapePrior prior;
  prior.grid.size = {3, 2, 2};
  prior.grid.spacing_mm = {2, 2, 2};
  prior.log_odds = {0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2};  // x/2
  prior.outside = -7;
  VolumeGeometry cells;
  cells.size = {7, 1, 1};
  cells.origin_mm = {-1, 1, 1};
  EXPECT_EQ(prior.at_cells(cells, run_serially()), (std::vector<float>{-7, 0, 0.5f, 1, 1.5f, 2, -7}));
}

TEST(ShapePrior, MovesTheObjectAndEnlargesTheRegion) {
  const Scene scene = ellipsoid(48, 1, {8, 8, 8}, 60);
  const Mark seed = inside({0, 0, 0}, 3);
  const auto prior = std::make_shared<ShapePrior>();
  prior->grid = scene.image.geometry();
  prior->bounds_mm = {Eigen::Vector3d(-20, -8, -8), Eigen::Vector3d(8, 8, 8)};
  prior->outside = -8;
  for (int k = 0; k < 48; ++k)
    for (int j = 0; j < 48; ++j)
      for (int i = 0; i < 48; ++i)
        prior->log_odds.push_back(scene.truth.voxels[scene.image.offset(i, j, k)] != 0 ? 8.0f : -8.0f);
  EvidenceField alone(scene.image), guided(scene.image);
  guided.set_shape_prior([&](std::span<const Mark>) { return prior; });
  alone.update({&seed, 1});
  guided.update({&seed, 1});
  const auto errors = [&](const EvidenceField& field) {
    const Mask object = field.object();
    std::size_t wrong = 0;
    for (std::size_t v = 0; v < object.voxels.size(); ++v) wrong += object.voxels[v] != scene.truth.voxels[v];
    return wrong;
  };
  EXPECT_LT(errors(guided), 0.5 * static_cast<double>(errors(alone)));
  EXPECT_LT(guided.box().first[0], alone.box().first[0]) << "the region contains the bounds of the prior";
}

TEST(ShapePrior, OfShareZeroChangesNothing) {
  const Scene scene = ellipsoid(40, 1, {8, 8, 8}, 20);
  const Mark seed = inside({0, 0, 0}, 3);
  EvidenceField alone(scene.image), silent(scene.image);
  const auto prior = std::make_shared<ShapePrior>();
  prior->grid.size = {1, 1, 1};
  prior->log_odds = {0};
  prior->bounds_mm = {seed.position_mm, seed.position_mm};
  prior->share = 0;
  silent.set_shape_prior([&](std::span<const Mark>) { return prior; });
  alone.update({&seed, 1});
  silent.update({&seed, 1});
  EXPECT_EQ(alone.object().voxels, silent.object().voxels);
}

}  // namespace
}  // namespace simplexseg
