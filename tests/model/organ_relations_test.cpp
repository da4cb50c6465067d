// SPDX-License-Identifier: Apache-2.0
// Models of several organs: relations of their poses, and organs that are found from others.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "model/model_start.h"
#include "model/model_training.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr double kDistance = 24;  ///< of neighbours in a row, mm
constexpr int kBodies = 4;

/// Row of equal ellipsoids along the third axis in noise, as vertebrae: their appearance does not distinguish them.
struct BodyRow {
  Volume image;
  std::vector<Mask> bodies;
  std::vector<Eigen::Vector3d> centres;
  double radius_mm = 0;  ///< depth of their centres
};

/// `without`: body that is missing; -1: none.
BodyRow make_row(std::uint32_t number, int without = -1) {
  std::mt19937 random(number + 1);
  const auto uniform = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
  const double scale = uniform(0.93, 1.07);
  VolumeGeometry grid;
  grid.size = {40, 44, 112};
  for (int a = 0; a < 3; ++a) grid.origin_mm[a] = -0.5 * (grid.size[a] - 1);
  BodyRow row{Volume(grid, VoxelType::Float32), {}, {}, 7 * scale};
  const Eigen::Vector3d start(uniform(-2, 2), uniform(-2, 2), -1.5 * scale * kDistance + uniform(-3, 3));
  for (int b = 0; b < kBodies; ++b) {
    row.centres.emplace_back(start + Eigen::Vector3d(uniform(-1, 1), uniform(-1, 1), b * scale * kDistance));
    row.bodies.push_back({grid, std::vector<std::uint8_t>(grid.voxel_count())});
  }
  const Eigen::Affine3d world = grid.world_from_index();
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i) {
        bool inside = false;
        const std::size_t v = row.image.offset(i, j, k);
        for (int b = 0; b < kBodies; ++b) {
          const Eigen::Vector3d p = world * Eigen::Vector3d(i, j, k) - row.centres[b];
          if (b == without || p.cwiseQuotient(scale * Eigen::Vector3d(10, 12, 7)).norm() > 1) continue;
          row.bodies[b].voxels[v] = 1;
          inside = true;
        }
        const double noise = uniform(-1, 1) + uniform(-1, 1) + uniform(-1, 1);  // deviation 1
        row.image.voxels<float>()[v] = static_cast<float>((inside ? 130 : 100) + 8 * noise);
      }
  return row;
}

/// Models of the first three bodies, trained on six rows.
const std::vector<OrganModel>& row_models() {
  static const std::vector<OrganModel> models = [] {
    std::vector<OrganModel> organs;
    for (const int body : {0, 1, 2}) {
      std::vector<ModelCase> cases;
      for (int n = 0; n < 6; ++n) {
        const BodyRow row = make_row(static_cast<std::uint32_t>(n));
        cases.push_back({"row", row.image, row.bodies[body], {}, n});
      }
      const TrainingSettings settings{.vertices = 250, .modes = 15};
      organs.push_back(train_model(register_cases(cases, settings, run_serially()), settings, run_serially()));
    }
    return organs;
  }();
  return models;
}
const PoseRelations& row_relations() {
  static const PoseRelations relations = train_relations(row_models());
  return relations;
}

FoundOrgan found_body(const BodyRow& row, int body) {
  const Mark seed{MarkKind::Inside, row.centres[body], row.radius_mm};
  return {body, ModelFitter(row_models()[body], row.image, run_serially()).fit({&seed, 1}).points};
}

TEST(OrganRelations, FindTheNeighboursOfAnOrganAndNotTheNextOnes) {
  for (std::uint32_t number = 100; number < 104; ++number) {
    const BodyRow row = make_row(number);
    for (const int from : {0, 1, 2}) {
      const std::vector<FoundSeed> seeds =
          find_organs(row_models(), row_relations(), row.image, {found_body(row, from)}, {0, 1, 2}, run_serially());
      ASSERT_EQ(seeds.size(), 2u) << "row " << number << " from body " << from;
      for (const FoundSeed& one : seeds) {
        EXPECT_NE(one.organ, from);
        EXPECT_LT((one.seed.position_mm - row.centres[one.organ]).norm(), 0.4 * row.radius_mm)
            << "row " << number << ": body " << one.organ << " from body " << from;
        EXPECT_NEAR(one.seed.radius_mm, row.radius_mm, 0.25 * row.radius_mm);
      }
    }
  }
}

TEST(OrganRelations, DoNotReplaceAMissingOrganByItsEqualNeighbour) {
  for (std::uint32_t number = 110; number < 114; ++number) {
    const BodyRow row = make_row(number, 2);  // the fourth body is as far from the third as the second
    const std::vector<FoundSeed> seeds =
        find_organs(row_models(), row_relations(), row.image, {found_body(row, 1)}, {0, 2}, run_serially());
    ASSERT_EQ(seeds.size(), 1u) << "row " << number;
    EXPECT_EQ(seeds[0].organ, 0);
    EXPECT_LT((seeds[0].seed.position_mm - row.centres[0]).norm(), 0.4 * row.radius_mm);
  }
}

TEST(OrganRelations, LeaveASeededOrganAtItsSeed) {
  // A model of one body stays at the seed, although its neighbours are equal.
  for (std::uint32_t number = 120; number < 123; ++number) {
    const BodyRow row = make_row(number);
    for (int body = 0; body < kBodies; ++body) {
      const Mark seed{MarkKind::Inside, row.centres[body] + Eigen::Vector3d(0, 0, 3), 0.7 * row.radius_mm};
      const OrganModel& model = row_models()[1];
      const ModelFit fit = ModelFitter(model, row.image, run_serially()).fit({&seed, 1});
      EXPECT_GT(dice(rasterise(mesh_at(model.shape.mean, fit.points), row.image.geometry()), row.bodies[body]), 0.85)
          << "row " << number << ", body " << body;
    }
  }
}

TEST(OrganRelations, ExpectPlaceAndSizeFromOtherOrgans) {
  const BodyRow row = make_row(130);
  std::vector<std::optional<PoseVector>> found(3);
  EXPECT_FALSE(expected_pose(row_relations(), row_models(), found, 2));
  found[1] = pose_of(row_models()[1].shape, found_body(row, 1).points);
  const auto from_one = expected_pose(row_relations(), row_models(), found, 2);
  ASSERT_TRUE(from_one);
  EXPECT_LT((from_one->mean.tail<3>() - row.centres[2]).norm(), 4);
  // The place moves with the others, and larger organs are farther apart.
  found[1]->tail<3>() += Eigen::Vector3d(5, -3, 40);
  const auto moved = expected_pose(row_relations(), row_models(), found, 2);
  EXPECT_LT((moved->mean.tail<3>() - from_one->mean.tail<3>() - Eigen::Vector3d(5, -3, 40)).norm(), 1e-3);
  (*found[1])[0] += 0.1;
  const auto larger = expected_pose(row_relations(), row_models(), found, 2);
  EXPECT_GT(larger->mean[0], moved->mean[0] + 0.02);
  EXPECT_GT((larger->mean - *found[1]).tail<3>().norm(), (moved->mean - *found[1]).tail<3>().norm() + 0.5);
  // A second organ makes it more certain.
  found[1] = pose_of(row_models()[1].shape, found_body(row, 1).points);
  found[0] = pose_of(row_models()[0].shape, found_body(row, 0).points);
  const auto from_two = expected_pose(row_relations(), row_models(), found, 2);
  EXPECT_LT(from_two->covariance.trace(), from_one->covariance.trace());
}

TEST(OrganRelations, NeedAnImageWithAllOrgans) {
  std::vector<OrganModel> organs{row_models()[0], row_models()[1]};
  EXPECT_EQ(train_relations({organs[0]}).organ_count(), 0);
  EXPECT_EQ(train_relations(organs).organ_count(), 2);
  for (TrainedCase& one : organs[1].cases) one.image_number += 100;
  EXPECT_THROW(train_relations(organs), Error);
}

}  // namespace
}  // namespace simplexseg
