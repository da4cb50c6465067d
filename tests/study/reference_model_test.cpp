// SPDX-License-Identifier: Apache-2.0
// Comparison of the model in double with the engines' kernels in float, and of its fixed points with their final poses.
#include "study/reference_model.h"

#include <cmath>

#include "forces/force_list.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"
#include "study/fixed_point.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

constexpr double kVoxelMm = 1;

/// Mesh with fixed image targets, for the model and for the engine.
struct FrozenScene {
  SimplexMesh mesh;
  ForceParameters forces = weightless();
  std::vector<Vec4> shape, targets;
  std::vector<Eigen::Vector3d> points_mm;

  ReferenceModel model(const Pose& pose) const {
    ReferenceScene scene;
    scene.neighbours = mesh.neighbours, scene.forces = forces, scene.shape = shape, scene.voxel_mm = kVoxelMm;
    for (const ForceInfo& force : force_list())
      if (force.targets != nullptr) scene.targets[static_cast<std::size_t>(force.id)] = targets;
    scene.points_mm = points_mm;
    return ReferenceModel(scene, pose);
  }
  std::unique_ptr<Engine> load(std::unique_ptr<Engine> engine, SimulationParameters simulation) const {
    TestScene scene;
    // Its voxels are not read; it defines the voxel size.
    scene.volume = volume();
    scene.meshes.resize(1);
    scene.meshes[0].mesh = mesh, scene.meshes[0].forces = forces, scene.meshes[0].shape = shape;
    for (const Eigen::Vector3d& p : points_mm) scene.points.push_back({0, p});
    scene.simulation = simulation;
    simplexseg::load(*engine, scene);
    for (const ForceInfo& force : force_list())
      if (force.targets != nullptr) engine->set_fixed_targets(0, force.id, targets);
    engine->set_parameters(std::vector{forces}, simulation);  // fixed targets replace recorded profiles
    return engine;
  }
  static const Volume& volume() {
    static const Volume made = [] {
      PhantomSettings settings;
      settings.size = 8, settings.spacing_mm = kVoxelMm;
      return make_phantom("flat", settings).image;
    }();
    return made;
  }
};

/// Noisy ellipsoid with targets on another ellipsoid, with confidences from 0 to 1.
FrozenScene noisy_scene(int level = 3) {
  FrozenScene s;
  const SimplexMesh sphere = make_sphere({0.3, -0.2, 0.1}, 20, level);
  const SimplexMesh goal = make_ellipsoid({1, 0, 0.5}, {21, 19, 20}, level);
  s.shape = shape_reference_of(sphere);
  s.mesh = make_ellipsoid({0.7, 0.4, -0.5}, {17.6, 19.1, 20.9}, level);
  s.mesh = with_noise(std::move(s.mesh), 0.2 * measure(s.mesh).mean_edge_mm);
  for (int i = 0; i < goal.vertex_count(); ++i) {
    const Eigen::Vector3f& p = goal.positions[static_cast<std::size_t>(i)];
    s.targets.push_back({p.x(), p.y(), p.z(), static_cast<float>(i % 5) / 4});
  }
  s.points_mm = {{23.1, 2.2, 1.3}, {-4.2, -14.1, 9.7}, {-4.0, -15.5, 9.0}};
  return s;
}

class ReferenceModelTest : public EngineTest {
 protected:
  /// Largest difference between the acceleration of the model and that of the engine: the move of one step at dt = 1
  /// with zero initial velocity.
  static double difference(const FrozenScene& s) {
    const auto engine = s.load(make_engine(), simulation(1, 1));
    EXPECT_FALSE(engine->step(1).failure.has_value());
    Positions after(s.mesh.positions.size()), before(after.size());
    engine->read(0, after, before);
    const Pose start = pose_of(s.mesh.positions);
    const Pose expected = start + s.model(start).acceleration(start);
    return (expected - pose_of(after)).colwise().norm().maxCoeff();
  }
};
SIMPLEXSEG_ON_EVERY_BACKEND(ReferenceModelTest);

// Positions of about 20 mm have a precision of 2e-6 mm in float. Forces are a few mm.
constexpr double kFloat = 2e-5;

TEST_P(ReferenceModelTest, EachForceIsTheEnginesAlone) {
  const std::vector<std::vector<Setting>> cases = {
      {{"smoothing", "weight", 0.7f}},
      {{"smoothing", "weight", 0.7f}, {"smoothing", "curvature", 0}},
      {{"smoothing", "weight", 0.7f}, {"smoothing", "evenness", 0}, {"smoothing", "elevation_limit", 0.05f}},
      {{"smoothing", "weight", 0.7f}, {"smoothing", "evenness", 3.1f}, {"smoothing", "elevation_limit", 2}},
      {{"shape_memory", "weight", 0.9f}},
      {{"shape_memory", "weight", 0.9f}, {"shape_memory", "scaling", 0}},
      {{"shape_memory", "weight", 0.9f}, {"shape_memory", "scaling", 0.8f}},
      {{"gradient", "weight", 0.6f}},
      {{"gradient", "weight", 0.6f}, {"gradient", "pull", 0}},
      {{"intensity_profile", "weight", 0.6f}, {"intensity_profile", "pull", 3}},
      {{"evidence", "weight", 0.6f}},
      {{"attraction", "weight", 0.8f}},
      {{"attraction", "weight", 0.8f}, {"attraction", "order", 0}},
      {{"attraction", "weight", 0.8f}, {"gradient", "weight", 0.6f}, {"attraction", "image_fade", 0.5f}},
  };
  for (const auto& settings : cases) {
    FrozenScene s = noisy_scene();
    for (const Setting& setting : settings) set(s.forces, setting);
    const Pose start = pose_of(s.mesh.positions);
    const Pose a = s.model(start).acceleration(start);
    EXPECT_GT(a.norm(), 1) << "a zero force would make the comparison meaningless";
    EXPECT_LT(difference(s), kFloat) << settings[0].force << ", last setting " << settings.back().parameter;
  }
}

TEST_P(ReferenceModelTest, AllForcesTogetherAreTheEngines) {
  FrozenScene s = noisy_scene(4);
  for (const ForceInfo& force : force_list()) weight_of(s.forces, force.id) = 0.3f;
  EXPECT_LT(difference(s), kFloat);
}

TEST_P(ReferenceModelTest, FoldsAndCollinearNeighboursAreTheEngines) {
  FrozenScene s = noisy_scene();
  set(s.forces, {"smoothing", "weight", 0.7f});
  set(s.forces, {"shape_memory", "weight", 0.3f});
  set(s.forces, {"gradient", "weight", 0.3f});
  // A vertex moved through the surface folds it; two coincident neighbours make the normal ambiguous.
  s.mesh.positions[40] *= 0.6f;
  const auto& nb = s.mesh.neighbours[200];
  s.mesh.positions[static_cast<std::size_t>(nb[1])] = s.mesh.positions[static_cast<std::size_t>(nb[0])];
  EXPECT_LT(difference(s), kFloat);
}

/// Scenes with a unique nearby fixed point: attraction points constrain motions without stiffness.
std::vector<FrozenScene> anchored_scenes() {
  std::vector<FrozenScene> scenes;
  auto add = [&scenes](std::initializer_list<Setting> settings) {
    FrozenScene s = noisy_scene();
    s.mesh = make_sphere({0.3, -0.2, 0.1}, 20, 3);
    s.points_mm = {{22, 0, 0}, {-20, 1, 0}, {0, 21, 3}, {1, -21, 0}, {0, 1, 22}};
    for (const Setting& setting : settings) set(s.forces, setting);
    set(s.forces, {"attraction", "weight", 1.2f});
    scenes.push_back(std::move(s));
  };
  add({{"smoothing", "weight", 2},
       {"smoothing", "curvature", 0.5f},
       {"evidence", "weight", 0.5f},
       {"evidence", "pull", 4}});
  add({{"shape_memory", "weight", 3}, {"gradient", "weight", 0.5f}, {"gradient", "pull", 0}});
  add({{"smoothing", "weight", 1}, {"smoothing", "evenness", 1}, {"intensity_profile", "weight", 1}});
  return scenes;
}

TEST_P(ReferenceModelTest, TheEngineEndsAtTheFixedPoint) {
  for (const FrozenScene& s : anchored_scenes()) {
    const Pose start = pose_of(s.mesh.positions);
    const ReferenceModel model = s.model(start);
    const FixedPoint found = find_fixed_point(model, start);
    EXPECT_TRUE(found.converged) << found.residual_mm << ", " << found.last_update_mm;
    EXPECT_LT(found.residual_mm, 1e-9);
    EXPECT_GT((found.pose - start).norm(), 10) << "a start at the fixed point would make the comparison meaningless";

    // The bindings are those of the first step. With more damping the run would end earlier, because moves fall below
    // the precision of floats.
    const SimulationParameters steps = limited(1, 0.3f, 1000000);
    const auto engine = s.load(make_engine(), steps);
    EXPECT_FALSE(engine->step(6000).failure.has_value());
    Positions after(s.mesh.positions.size()), before(after.size());
    engine->read(0, after, before);
    EXPECT_LT((found.pose - pose_of(after)).colwise().norm().maxCoeff(), 1e-4 * kVoxelMm);
  }
}

TEST(ReferenceModel, TwoStartsFindOneFixedPoint) {
  for (const FrozenScene& s : anchored_scenes()) {
    const Pose start = pose_of(s.mesh.positions);
    const ReferenceModel model = s.model(start);
    const FixedPoint one = find_fixed_point(model, start);
    const FixedPoint other = find_fixed_point(model, pose_of(with_noise(s.mesh, 0.3).positions));
    EXPECT_TRUE(one.converged && other.converged);
    EXPECT_FALSE(one.drifts || other.drifts);
    EXPECT_LT((one.pose - other.pose).colwise().norm().maxCoeff(), 2e-8);
  }
}

TEST(ReferenceModel, DerivativeAndJacobianAgreeWithDifferences) {
  FrozenScene s = noisy_scene();
  for (const ForceInfo& force : force_list()) weight_of(s.forces, force.id) = 0.3f;
  const Pose x = pose_of(s.mesh.positions);
  const ReferenceModel model = s.model(x);
  const Pose v = pose_of(with_noise({Positions(s.mesh.positions.size(), {0, 0, 0}), {}}, 1).positions);
  const double h = 1e-6;
  const Pose differences = (model.acceleration(x + h * v) - model.acceleration(x - h * v)) / (2 * h);
  const Pose exact = model.derivative(x, v);
  EXPECT_LT((exact - differences).norm(), 1e-6 * exact.norm());
  const Eigen::VectorXd product = model.jacobian(x) * Eigen::Map<const Eigen::VectorXd>(v.data(), v.size());
  EXPECT_LT((Eigen::Map<const Pose>(product.data(), 3, x.cols()) - exact).norm(), 1e-12 * exact.norm());
}

TEST(ReferenceModel, ShapeMemoryAloneReturnsToItsReferenceUpToASimilarity) {
  FrozenScene s = noisy_scene();
  set(s.forces, {"shape_memory", "weight", 1});
  s.points_mm.clear();
  const SimplexMesh sphere = make_sphere({0.3, -0.2, 0.1}, 20, 3);
  const Pose start = pose_of(with_noise(sphere, 0.05).positions);
  const FixedPoint found = find_fixed_point(s.model(start), start);
  EXPECT_TRUE(found.converged);
  EXPECT_TRUE(found.drifts) << "similarities have no stiffness";
  EXPECT_LT(found.residual_mm, 1e-8);
  EXPECT_LT((found.pose - start).colwise().norm().maxCoeff(), 1) << "it stays near its start";
  const Eigen::Vector3d centre = found.pose.rowwise().mean();
  const Eigen::VectorXd radii = (found.pose.colwise() - centre).colwise().norm();
  EXPECT_LT(radii.maxCoeff() - radii.minCoeff(), 1e-4);
}

TEST(ReferenceModel, SizesThatDoNotFitAreRefused) {
  FrozenScene s = noisy_scene();
  s.shape.pop_back();
  EXPECT_ANY_THROW(s.model(pose_of(s.mesh.positions)));
}

}  // namespace
}  // namespace simplexseg
