// SPDX-License-Identifier: Apache-2.0
// The stability bound (docs/mathematics.md, section 3) against what the engine does.
#include "core/stability.h"

#include <cmath>

#include "core/shape_reference.h"
#include "engine_fixture.h"

namespace simplexseg {
namespace {

class StabilityTest : public EngineTest {
 protected:
  /// Largest timestep at which the scene's deviation from its fixed point does not grow, by bisection.
  template <class Deviation>
  static double measured_limit(const TestScene& scene, double damping, double predicted, const Deviation& deviation) {
    auto grows = [&](double timestep) {
      TestScene s = scene;
      s.simulation = simulation(static_cast<float>(timestep), static_cast<float>(damping), 50);
      const auto engine = make_engine();
      load(*engine, s);
      const double before = deviation(positions_of(*engine, s));
      for (int batch = 0; batch < 12; ++batch) {
        if (engine->step(50).failure) return true;
        const double now = deviation(positions_of(*engine, s));
        if (!(now < 20 * before)) return true;
        if (now < 1e-2 * before) return false;
      }
      return false;
    };
    double stable = 0.5 * predicted, unstable = 2 * predicted;
    EXPECT_FALSE(grows(stable));
    EXPECT_TRUE(grows(unstable));
    while (unstable / stable > 1.005) {
      const double middle = 0.5 * (stable + unstable);
      (grows(middle) ? unstable : stable) = middle;
    }
    return stable;
  }
};
SIMPLEXSEG_ON_EVERY_BACKEND(StabilityTest);

constexpr double kDampings[] = {0.1, 0.3, 0.9};

double root_mean_square(const Positions& a, const Positions& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += (a[k] - b[k]).cast<double>().squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

TEST_P(StabilityTest, ShapeMemory) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  const SimplexMesh reference = make_sphere({0, 0, 0}, 20, 2);
  m.shape = shape_reference_of(reference);
  m.mesh = with_noise(reference, 0.01);
  m.forces = with({{"shape_memory", "weight", 0.8f}, {"shape_memory", "scaling", 0}});
  for (double damping : kDampings) {
    const double predicted = stable_timestep(stiffness_bound(m.forces, m.shape), static_cast<float>(damping));
    // Rigid motions cost nothing and may stay: the elevations tell.
    auto deviation = [&](const Positions& p) {
      double sum = 0;
      for (int i = 0; i < reference.vertex_count(); ++i)
        sum += std::pow(vertex_geometry({p, reference.neighbours}, i).elevation_mm - m.shape[i].z, 2);
      return std::sqrt(sum / reference.vertex_count());
    };
    EXPECT_NEAR(std::pow(measured_limit(scene, damping, predicted, deviation) / predicted, 2), 1, 0.05)
        << "damping " << damping;
  }
}

TEST_P(StabilityTest, LaplacianSmoothing) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  // Linear: its fixed point is a point, and noise around it is all there is to grow or shrink.
  m.mesh = make_sphere({0, 0, 0}, 1, 3);
  for (Eigen::Vector3f& p : m.mesh.positions) p.setZero();
  m.mesh = with_noise(m.mesh, 1);
  m.forces = with({{"smoothing", "weight", 0.8f}, {"smoothing", "evenness", 0}, {"smoothing", "curvature", 0}});
  const Positions origin(m.mesh.positions.size(), Eigen::Vector3f::Zero());
  for (double damping : kDampings) {
    const double predicted = stable_timestep(stiffness_bound(m.forces, {}), static_cast<float>(damping));
    auto deviation = [&](const Positions& p) { return root_mean_square(p, origin); };
    EXPECT_NEAR(std::pow(measured_limit(scene, damping, predicted, deviation) / predicted, 2), 1, 0.05)
        << "damping " << damping;
  }
}

TEST_P(StabilityTest, EvenSmoothingIsStableWithinItsBound) {
  // With weights that follow the edge lengths the bound holds for the worst mesh; on a sphere the limit is at (2 + a)
  // k.
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = with_noise(make_sphere({0, 0, 0}, 20, 3), 0.001);
  for (float evenness : {1.0f, 2.0f, 4.0f}) {
    m.forces =
        with({{"smoothing", "weight", 0.8f}, {"smoothing", "evenness", evenness}, {"smoothing", "elevation_limit", 2}});
    const double predicted = stable_timestep(stiffness_bound(m.forces, {}), 0.9f);
    const double on_sphere = std::sqrt(2.2 / (0.8 * (2 + evenness)));
    EXPECT_LE(predicted, 1.025 * on_sphere);
    auto last_move = [&](double timestep) {
      scene.simulation = simulation(static_cast<float>(timestep), 0.9f);
      const auto engine = make_engine();
      load(*engine, scene);
      const StepOutcome outcome = engine->step(600);
      return outcome.failure ? INFINITY : outcome.mean_move_mm[0];
    };
    EXPECT_LT(last_move(0.98 * std::min(predicted, on_sphere)), 1e-3) << "evenness " << evenness;
    EXPECT_GT(last_move(1.05 * on_sphere), 1e-2) << "evenness " << evenness;
  }
}

/// One vertex on a spring to a point 0.01 mm away.
TestScene one_oscillator(float weight) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = make_sphere({0, 0, 0}, 20, 2);
  m.forces = with({{"attraction", "weight", weight}, {"attraction", "order", 0}});
  scene.points = {{0, 1.0005 * m.mesh.positions[7].cast<double>()}};
  return scene;
}

TEST_P(StabilityTest, AttractionAndImageForces) {
  const TestScene scene = one_oscillator(0.8f);
  const Eigen::Vector3f point = scene.points[0].position_mm.cast<float>();
  for (double damping : kDampings) {
    const double predicted = stable_timestep(stiffness_bound(scene.meshes[0].forces, {}), static_cast<float>(damping));
    auto deviation = [&](const Positions& p) { return static_cast<double>((p[7] - point).norm()); };
    EXPECT_NEAR(std::pow(measured_limit(scene, damping, predicted, deviation) / predicted, 2), 1, 0.05)
        << "damping " << damping;
  }
}

TEST_P(StabilityTest, AnUndampedModeHasThePeriodOfTheDiscreteOscillator) {
  for (double stiffness : {0.05, 0.4, 2.0}) {  // k dt^2
    TestScene scene = one_oscillator(static_cast<float>(stiffness));
    const Eigen::Vector3d c = scene.points[0].position_mm, start = scene.meshes[0].mesh.positions[7].cast<double>() - c;
    scene.simulation = simulation(1, 0);
    const auto engine = make_engine();
    load(*engine, scene);
    // x+ - 2x + x- = -k dt^2 x from rest: x_n = x_0 cos(omega (n + 1/2)) / cos(omega / 2), cos(omega) = 1 - k dt^2 / 2.
    const double omega = std::acos(1 - 0.5 * stiffness);
    double worst = 0;
    for (int n = 1; n <= 150; ++n) {
      engine->step(1);
      const double x = (positions_of(*engine, scene)[7].cast<double>() - c).dot(start) / start.squaredNorm();
      worst = std::max(worst, std::abs(x - std::cos(omega * (n + 0.5)) / std::cos(0.5 * omega)));
    }
    EXPECT_LT(worst, 0.05) << "k dt^2 = " << stiffness;  // float positions resolve 2e-4 of the amplitude
  }
}

TEST_P(StabilityTest, TheLimitKeepsExtremeWeightsBounded) {
  for (float damping : {0.1f, 0.9f})
    for (float timestep : {1.0f, 10.0f}) {
      TestScene scene = busy_scene(3, 10);
      for (const ForceInfo& force : force_list())
        weight_of(scene.meshes[0].forces, force.id) = force.parameters[0].maximum;
      scene.simulation = limited(timestep, damping, 3);
      const Positions end = run(scene, 500);
      double farthest = 0;
      for (const Eigen::Vector3f& p : end) farthest = std::max(farthest, static_cast<double>(p.norm()));
      EXPECT_LT(farthest, 60) << "damping " << damping << ", timestep "
                              << timestep;  // the volume's corners lie at 55 mm
    }
}

TEST_P(StabilityTest, TheLimitIsNineTenthsOfTheBound) {
  SimulationParameters s = limited(10, 0.3f);
  EXPECT_NEAR(effective_timestep(s, 2), 0.9 * std::sqrt(3.4 / 2), 1e-6);
  s.timestep = 0.1f;
  EXPECT_EQ(effective_timestep(s, 2), 0.1f);
  s.timestep = 10, s.limit_timestep = 0;
  EXPECT_EQ(effective_timestep(s, 2), 10);
  EXPECT_TRUE(std::isinf(stable_timestep(0, 0.3f)));
}

}  // namespace
}  // namespace simplexseg
