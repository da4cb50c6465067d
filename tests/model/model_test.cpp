// SPDX-License-Identifier: Apache-2.0
// Models of shape and profiles: registration of the template, training, instances in images, and the prior of the
// field.
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/thread_pool.h"
#include "field/evidence_field.h"
#include "field/robot_user.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "model/model_fit.h"
#include "model/model_prior.h"
#include "model/model_start.h"
#include "model/template_registration.h"
#include "organ_family.h"

namespace simplexseg {
namespace {

Mark seed_in(const Mask& object) {
  const auto deepest = deepest_voxel(object);
  const auto [i, j, k] = deepest->voxel;
  return {MarkKind::Inside, object.geometry.world_from_index() * Eigen::Vector3d(i, j, k), deepest->depth_mm};
}

Mask mask_at(const OrganModel& model, const Eigen::Matrix3Xd& points, const VolumeGeometry& grid) {
  return rasterise(mesh_at(model.shape.mean, points), grid);
}

TEST(Similarity, IsRecoveredAndNeverAReflection) {
  const Eigen::Matrix3Xd from = Eigen::Matrix3Xd::Random(3, 30);
  const Similarity truth{1.7, rotation_of({0.4, -1.1, 0.3}), {5, -2, 9}};
  const Similarity found = fit_similarity(from, truth(from));
  EXPECT_NEAR(found.scale, 1.7, 1e-12);
  EXPECT_LT((found.rotation - truth.rotation).norm(), 1e-12);
  EXPECT_LT((found.shift_mm - truth.shift_mm).norm(), 1e-12);
  EXPECT_LT((rotation_vector(found.rotation) - Eigen::Vector3d(0.4, -1.1, 0.3)).norm(), 1e-9);
  Eigen::Matrix3Xd mirrored = from;
  mirrored.row(0) *= -1;
  EXPECT_NEAR(fit_similarity(from, mirrored).rotation.determinant(), 1, 1e-9);
}

TEST(TemplateRegistration, PutsVerticesOnTheSurfaceWithoutFoldsAndPolesOnPoles) {
  const std::vector<ModelCase> cases = make_organs(0, 6);
  const RegisteredCases registered = register_cases(cases, {.vertices = 400}, run_serially());
  ASSERT_EQ(registered.cases.size(), 6u);
  // The vertex at one end of the long axis of the template is at that end in each case.
  Eigen::Index pole = 0;
  points_of(registered.mesh).row(1).maxCoeff(&pole);
  for (const RegisteredCase& one : registered.cases) {
    EXPECT_LT(one.distance_mm, 1.5) << one.data->name << ": distance between vertices of two meshes";
    EXPECT_EQ(one.folded, 0) << one.data->name;
    EXPECT_GT(dice(rasterise(mesh_at(registered.mesh, one.points), one.data->object.geometry), one.data->object), 0.95)
        << one.data->name;
    EXPECT_GT(one.points(1, pole), one.points.row(1).maxCoeff() - 4) << one.data->name;
  }
}

TEST(Model, FindsAnUnseenOrganFromItsSeedBetterThanTheMeanShapeAndTheFieldAlone) {
  const OrganModel& model = model_of_organs();
  double mean_shape = 0, fitted = 0, field_alone = 0, field_with_model = 0;
  constexpr int kCases = 4;
  for (int n = 0; n < kCases; ++n) {
    const ModelCase organ = make_organ(static_cast<std::uint32_t>(100 + n));
    const VolumeGeometry& grid = organ.object.geometry;
    const Mark seed = seed_in(organ.object);
    ModelFitter fitter(model, organ.image, run_serially());
    const ModelFit fit = fitter.fit({&seed, 1});
    fitted += dice(mask_at(model, fit.points, grid), organ.object) / kCases;
    const Similarity pose{1, Eigen::Matrix3d::Identity(), seed.position_mm};
    mean_shape += dice(mask_at(model, pose(points_of(model.shape.mean)), grid), organ.object) / kCases;
    EvidenceField alone(organ.image), with_model(organ.image);
    with_model.set_shape_prior(
        shape_prior_maker(std::make_shared<const OrganModel>(model), organ.image, run_serially()));
    alone.update({&seed, 1});
    with_model.update({&seed, 1});
    field_alone += dice(alone.object(), organ.object) / kCases;
    field_with_model += dice(with_model.object(), organ.object) / kCases;
  }
  EXPECT_GT(fitted, 0.92);
  EXPECT_GT(fitted, mean_shape + 0.05);
  EXPECT_GT(field_with_model, 0.92);
  EXPECT_GT(field_with_model, field_alone + 0.03);
}

TEST(Model, HasEqualBitsForAnyNumberOfThreadsAndAnyOrderOfFits) {
  const OrganModel& model = model_of_organs();
  const ModelCase organ = make_organ(200);
  const Mark seed = seed_in(organ.object);
  const std::vector<Mark> marks{seed, {MarkKind::Outside, seed.position_mm + Eigen::Vector3d(12, 0, 0), 2}};
  ModelFitter serial(model, organ.image, run_serially());
  ThreadPool pool(3);
  ModelFitter parallel(model, organ.image, [&](int jobs, const auto& job) { pool.run(jobs, job); });
  const ModelFit first = serial.fit(marks);
  parallel.fit({&seed, 1});
  EXPECT_EQ(first.points, parallel.fit(marks).points);
  EXPECT_NE(first.points, parallel.fit({&seed, 1}).points);
}

TEST(Model, FollowsMarks) {
  const OrganModel& model = model_of_organs();
  const ModelCase organ = make_organ(201);
  const Mark seed = seed_in(organ.object);
  ModelFitter fitter(model, organ.image, run_serially());
  const ModelFit before = fitter.fit({&seed, 1});
  Eigen::Index pole = 0;
  before.points.row(1).maxCoeff(&pole);
  const Eigen::Vector3d place = before.points.col(pole) + Eigen::Vector3d(0, 3, 0);
  const std::vector<Mark> marks{seed, {MarkKind::Boundary, place, 1, {0, 1, 0}}};
  const ModelFit after = fitter.fit(marks);
  EXPECT_LT((after.points.colwise() - place).colwise().norm().minCoeff(), 1.5);
  EXPECT_GT((before.points.colwise() - place).colwise().norm().minCoeff(), 2.0);
}

TEST(Model, OfAnotherAppearanceOrSizeIsSilent) {
  const OrganModel& model = model_of_organs();
  const ModelCase same = make_organ(202), dark = make_organ(202, {.inside = 70});
  const Mark seed = seed_in(same.object);
  const auto trust = [&](const Volume& image, const Mark& mark) {
    return trust_in(model, ModelFitter(model, image, run_serially()).fit({&mark, 1}));
  };
  EXPECT_GT(trust(same.image, seed), 0.8);
  EXPECT_EQ(trust(dark.image, seed), 0) << "dark where the model is bright";
  EXPECT_EQ(trust(same.image, {MarkKind::Inside, seed.position_mm, 0.3 * seed.radius_mm}), 0);
  EvidenceField alone(dark.image), with_model(dark.image);
  with_model.set_shape_prior(shape_prior_maker(std::make_shared<const OrganModel>(model), dark.image, run_serially()));
  alone.update({&seed, 1});
  with_model.update({&seed, 1});
  EXPECT_EQ(alone.object().voxels, with_model.object().voxels);
}

TEST(Model, NeedsNoDataBeyondTheVolume) {
  const OrganModel& model = model_of_organs();
  for (const std::uint32_t number : {203u, 204u}) {
    const ModelCase cut = make_organ(number, {.shift_x_mm = 20});  // cuts about a third of the organ
    const Mark seed = seed_in(cut.object);
    ModelFitter fitter(model, cut.image, run_serially());
    const ModelFit fit = fitter.fit({&seed, 1});
    EXPECT_LT(fit.points.row(0).minCoeff(), cut.image.geometry().origin_mm[0] - 0.5) << "vertices beyond the volume";
    EXPECT_GT(dice(mask_at(model, fit.points, cut.object.geometry), cut.object), 0.85) << "visible part";
  }
}

TEST(Model, WithoutAPromptStartsAtItsPlaceInTheVolume) {
  const OrganModel& model = model_of_organs();
  const ModelCase organ = make_organ(205);
  const ModelFit fit = ModelFitter(model, organ.image, run_serially()).fit({});
  EXPECT_GT(dice(mask_at(model, fit.points, organ.object.geometry), organ.object), 0.9);
}

TEST(Model, FindsTheSeedOfAnUnmarkedOrganAndNothingInAnotherImage) {
  const OrganModel& model = model_of_organs();
  const ModelCase organ = make_organ(206), dark = make_organ(206, {.inside = 70});
  const std::optional<Mark> seed = find_organ(model, organ.image, run_serially());
  ASSERT_TRUE(seed);
  const Mark truth = seed_in(organ.object);
  EXPECT_LT((seed->position_mm - truth.position_mm).norm(), 0.5 * truth.radius_mm);
  EXPECT_NEAR(seed->radius_mm, truth.radius_mm, 0.2 * truth.radius_mm);
  EXPECT_FALSE(find_organ(model, dark.image, run_serially()));
}

TEST(Model, ExplainsTheCasesInOrderOfVariance) {
  const ShapeModel& shape = model_of_organs().shape;
  for (int m = 1; m < shape.mode_count(); ++m)
    EXPECT_LE(shape.modes.col(m).norm(), shape.modes.col(m - 1).norm() * 1.0001f);
  // Similarities belong to the pose: no mode translates or scales.
  const Eigen::Map<const Eigen::VectorXf> mean(shape.mean.positions[0].data(), 3 * shape.vertex_count());
  for (int m = 0; m < 5; ++m) {
    EXPECT_NEAR(shape.modes.col(m).dot(mean) / (shape.modes.col(m).norm() * mean.norm()), 0, 1e-3);
    const Eigen::Map<const Eigen::Matrix3Xf> moves(shape.modes.col(m).data(), 3, shape.vertex_count());
    EXPECT_LT(moves.rowwise().mean().norm(), 1e-3f * moves.colwise().norm().maxCoeff());
  }
}

TEST(Model, OfAnEmptyObjectOrNoCaseIsRefused) {
  EXPECT_THROW(register_cases({}, {}, run_serially()), Error);
  std::vector<ModelCase> cases = make_organs(0, 1);
  std::ranges::fill(cases[0].object.voxels, std::uint8_t{0});
  EXPECT_THROW(register_cases(cases, {}, run_serially()), Error);
}

}  // namespace
}  // namespace simplexseg
