// SPDX-License-Identifier: Apache-2.0
// Models to which single cases are added.
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/thread_pool.h"
#include "field/robot_user.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "model/model_fit.h"
#include "model/template_registration.h"
#include "organ_family.h"

namespace simplexseg {
namespace {

const TrainingSettings kGrowing{.vertices = 400, .modes = 40};

/// Model of the first `count` organs: trained on one, to which the others are added.
OrganModel grown_model(int count, const RunJobs& run) {
  const std::vector<ModelCase> cases = make_organs(0, count);
  OrganModel model = train_model(register_cases({cases[0]}, kGrowing, run), kGrowing, run);
  for (int c = 1; c < count; ++c) model = add_case(model, cases[c], kGrowing.modes, run).model;
  return model;
}

double mean_dice_on_unseen_organs(const OrganModel& model) {
  double sum = 0;
  constexpr int kCases = 4;
  for (int n = 0; n < kCases; ++n) {
    const ModelCase organ = make_organ(static_cast<std::uint32_t>(100 + n));
    const auto deepest = deepest_voxel(organ.object);
    const auto [i, j, k] = deepest->voxel;
    const Mark seed{MarkKind::Inside, organ.object.geometry.world_from_index() * Eigen::Vector3d(i, j, k),
                    deepest->depth_mm};
    const ModelFit fit = ModelFitter(model, organ.image, run_serially()).fit({&seed, 1});
    sum += dice(rasterise(mesh_at(model.shape.mean, fit.points), organ.object.geometry), organ.object);
  }
  return sum / kCases;
}

TEST(GrowingModel, IsAsGoodAsOneTrainedOnAllCasesAndBetterThanOneOfOneCase) {
  const OrganModel grown = grown_model(12, run_serially());
  const double many = mean_dice_on_unseen_organs(grown),
               one = mean_dice_on_unseen_organs(grown_model(1, run_serially()));
  EXPECT_GT(many, mean_dice_on_unseen_organs(model_of_organs()) - 0.01);
  EXPECT_GT(many, one + 0.01);
  EXPECT_EQ(grown.cases.size(), 12u);
}

TEST(GrowingModel, HasEqualBitsForAnyNumberOfThreadsAndDependsOnTheOrder) {
  ThreadPool pool(3);
  const OrganModel a = grown_model(3, run_serially()),
                   b = grown_model(3, [&](int jobs, const auto&job) { pool.run(jobs, job); });
  EXPECT_EQ(a.shape.modes, b.shape.modes);
  EXPECT_EQ(a.profiles.whitening, b.profiles.whitening);
  EXPECT_EQ(a.surface_error_mm, b.surface_error_mm);
  const std::vector<ModelCase> cases = make_organs(0, 3);
  OrganModel other = train_model(register_cases({cases[0]}, kGrowing, run_serially()), kGrowing, run_serially());
  for (const int c : {2, 1}) other = add_case(other, cases[c], kGrowing.modes, run_serially()).model;
  EXPECT_NE(a.shape.modes, other.shape.modes);
}

TEST(GrowingModel, MeasuresItsErrorOnEachCaseBeforeItIsAdded) {
  const std::vector<ModelCase> cases = make_organs(0, 3);
  const OrganModel one = train_model(register_cases({cases[0]}, kGrowing, run_serially()), kGrowing, run_serially());
  EXPECT_EQ(one.cases[0].error_cases, 0);
  const AddedCase two = add_case(one, cases[1], kGrowing.modes, run_serially());
  const AddedCase three = add_case(two.model, cases[2], kGrowing.modes, run_serially());
  EXPECT_EQ(two.registered.data, &cases[1]);
  EXPECT_LT(two.registered.distance_mm, 1.5);
  ASSERT_EQ(three.model.cases.size(), 3u);
  EXPECT_EQ(three.model.cases[1].error_cases, 1);
  EXPECT_EQ(three.model.cases[2].error_cases, 2);
  EXPECT_GT(three.model.cases[1].error_mm, 0);
  EXPECT_EQ(two.model.surface_error_mm, two.model.cases[1].error_mm);
  const double a = three.model.cases[1].error_mm, b = three.model.cases[2].error_mm;
  EXPECT_NEAR(three.model.surface_error_mm, std::sqrt((a * a + 2 * b * b) / 3), 1e-12);
  // Earlier cases are not registered again.
  EXPECT_EQ(three.model.cases[0].points, one.cases[0].points);
  EXPECT_EQ(three.model.cases[0].profiles, one.cases[0].profiles);
}

TEST(GrowingModel, WithoutShapesOfItsCasesAndAnEmptyObjectAreRefused) {
  std::vector<ModelCase> cases = make_organs(0, 2);
  OrganModel model = train_model(register_cases({cases[0]}, kGrowing, run_serially()), kGrowing, run_serially());
  EXPECT_TRUE(can_grow(model));
  OrganModel without = model;
  without.cases[0].points.resize(3, 0);
  EXPECT_FALSE(can_grow(without));
  EXPECT_THROW(add_case(without, cases[1], 40, run_serially()), Error);
  std::ranges::fill(cases[1].object.voxels, std::uint8_t{0});
  EXPECT_THROW(add_case(model, cases[1], 40, run_serially()), Error);
}

}  // namespace
}  // namespace simplexseg
