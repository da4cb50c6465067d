// SPDX-License-Identifier: Apache-2.0
// Study of error against time: every solver reaches the known fixed points, and the reported numbers are correct.
#include "study/error_time.h"

#include <algorithm>
#include <set>

#include "core/error.h"
#include "study/error_time_report.h"
#include "study/trials.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

const Poll no_poll = [] {};
std::unique_ptr<Engine> one_thread() { return make_cpu_engine(1); }

TEST(FrozenProblem, TheMembranesFixedPointIsThatOfTheModelInDouble) {
  for (const bool half : {false, true}) {
    const FrozenProblem problem = make_membrane(half, 300);
    ASSERT_TRUE(problem.converged);
    ASSERT_EQ(problem.vertex_count(), 320);
    const FrozenMesh& mesh = problem.meshes[0];
    ReferenceScene scene;
    scene.neighbours = mesh.start.neighbours, scene.forces = mesh.forces, scene.points_mm = mesh.points_mm;
    const ReferenceModel model(scene, pose_of(mesh.start.positions));
    EXPECT_LT(model.acceleration(mesh.end).cwiseAbs().maxCoeff(), 1e-5);  // points are stored in single precision
    EXPECT_GT(model.acceleration(pose_of(mesh.start.positions)).cwiseAbs().maxCoeff(), 0.1);
    EXPECT_GT(problem.start_mm.whole, 0.5);
    EXPECT_GE(problem.start_mm.whole, problem.start_mm.normal);
  }
  EXPECT_LT(make_membrane(true, 320).meshes[0].points_mm.size(), make_membrane(false, 320).meshes[0].points_mm.size());
}

TEST(FrozenProblem, APhantomsFixedPointIsFoundAndItsTargetsAreThoseOfTheImage) {
  for (const bool half : {false, true}) {
    const StudyScene study = make_phantom_scene(half, 320);
    const FrozenProblem problem = frozen_problem_of(study.scene, study.volume, true, one_thread, no_poll);
    EXPECT_TRUE(problem.converged) << problem.how;
    const auto& targets = problem.meshes[0].targets[static_cast<std::size_t>(ForceId::Gradient)];
    ASSERT_EQ(targets.size(), 320u);
    int trusted = 0;
    for (const Vec4& t : targets) {
      if (t.w == 0) continue;
      ++trusted;
      // The targets are on the surface of the ellipsoid.
      EXPECT_NEAR((Eigen::Vector3d(t.x / 26, t.y / 24, t.z / 22)).norm(), 1, 0.02);
    }
    EXPECT_GT(trusted, half ? 120 : 310);
    EXPECT_LE(trusted, half ? 190 : 320);
  }
}

TEST(FrozenProblem, OnlyBoundaryPointsAttract) {
  StudyScene study = make_phantom_scene(false, 320);
  study.scene.meshes[0].id = 1;
  for (const MarkKind kind : {MarkKind::Inside, MarkKind::Outside, MarkKind::Boundary}) {
    UserPoint point{static_cast<ItemId>(2 + study.scene.points.size()), 1, {26, 0, 0}};
    point.kind = kind;
    study.scene.points.push_back(point);
  }
  const FrozenProblem problem = frozen_problem_of(study.scene, study.volume, true, one_thread, no_poll);
  EXPECT_EQ(problem.meshes[0].points_mm.size(), 1u);
}

TEST(FrozenProblem, OfASceneItStartsWhereTheLastLevelBegan) {
  StudyScene study = make_phantom_scene(false, 320);
  study.scene.simulation.start_vertices = 80;
  study.scene.simulation.steps_per_level = 20;
  const FrozenProblem problem = frozen_problem_of(study.scene, study.volume, false, one_thread, no_poll);
  EXPECT_EQ(problem.meshes[0].start.vertex_count(), 320);
  EXPECT_TRUE(problem.converged) << problem.how;
  // The previous level has moved it near the fixed point.
  EXPECT_LT(problem.start_mm.normal, 1);
  EXPECT_THROW(frozen_problem_of(Scene{}, study.volume, false, one_thread, no_poll), Error);
}

TEST(FrozenCurve, EverySolverGoesToTheSameFixedPoint) {
  const FrozenProblem problem = make_membrane(false, 320);
  const std::vector<Method> methods = methods_for(problem);
  std::set<int> solvers;
  int baselines = 0;
  for (const Method& method : methods) {
    solvers.insert(method.solver);
    baselines += method.baseline;
    const FrozenCurve curve = run_frozen(problem, method, 20, 0, one_thread, no_poll);
    EXPECT_EQ(curve.note, "") << method.name;
    EXPECT_EQ(curve.samples.front().whole, 1);
    EXPECT_LT(curve.samples.back().whole, 1e-3) << method.name;
    for (std::size_t s = 1; s < curve.samples.size(); ++s) {
      EXPECT_GT(curve.samples[s].steps, curve.samples[s - 1].steps);
      EXPECT_GE(curve.samples[s].seconds, curve.samples[s - 1].seconds);
    }
  }
  EXPECT_EQ(solvers.size(), solver_names().size());
  EXPECT_EQ(baselines, 1);
}

TEST(FrozenCurve, ABudgetEndsIt) {
  const FrozenProblem problem = make_membrane(true, 5120);
  const auto methods = methods_for(problem);
  const auto slow = std::find_if(methods.begin(), methods.end(),
                                 [](const Method& m) { return m.name == "verlet, damping 0.9, 50%"; });
  ASSERT_NE(slow, methods.end());
  const FrozenCurve curve = run_frozen(problem, *slow, 1e-3, 0, one_thread, no_poll);
  EXPECT_GT(curve.samples.back().whole, 0.1);
  struct Stop {};
  EXPECT_THROW(run_frozen(problem, *slow, 1e6, 0, one_thread, [] { throw Stop(); }), Stop);
}

TEST(Reached, IsForGood) {
  const std::vector<FrozenSample> samples{
      {0, 0, 1, 1}, {1, 0.1, 0.05, 0.5}, {2, 0.2, 0.2, 0.05}, {3, 0.3, 0.09, 0.04}, {4, 0.4, 0.001, 0.2}};
  const auto at = reached(samples, 0.1, false);
  ASSERT_TRUE(at);
  EXPECT_EQ(at->steps, 3);
  EXPECT_DOUBLE_EQ(at->seconds, 0.3);
  EXPECT_FALSE(reached(samples, 0.1, true));
  EXPECT_EQ(reached(samples, 2, true)->steps, 0);
}

TEST(LiveStudy, RunsOfAPhantomEndOnItsTruth) {
  const StudyScene study = make_phantom_scene(false, 1280);
  const LiveStudy live(study);
  ASSERT_TRUE(live.has_truth());
  EXPECT_FALSE(LiveStudy(make_phantom_scene(true, 80)).has_truth());
  for (const LiveVariant& variant : {LiveVariant{0, 3, true}, LiveVariant{0, 1, false}}) {
    const LiveCurve curve = live.run(variant, 60, one_thread, no_poll);
    ASSERT_EQ(curve.meshes.size(), 1u);
    const LiveSample &first = curve.meshes[0].front(), &last = curve.meshes[0].back();
    EXPECT_EQ(first.vertices, variant.coarse_to_fine ? 320 : 1280);
    EXPECT_EQ(last.vertices, 1280);
    EXPECT_GT(first.error.mean_mm, 0.7);
    EXPECT_LT(last.error.mean_mm, 0.4);
    EXPECT_LT(first.dice, 0.97);
    EXPECT_GT(last.dice, 0.98);
  }
  std::set<std::array<int, 3>> different;
  for (const LiveVariant& v : live_variants()) different.insert({v.solver, v.refresh_interval, v.coarse_to_fine});
  EXPECT_EQ(different.size(), 6 * solver_names().size());
}

TEST(ErrorTimeReport, TheTableComparesWithTheMeasure) {
  ErrorTimeResult result;
  result.name = "case", result.backend = "cpu", result.device = "CPU", result.vertices = 7, result.how = "known";
  Method fast{"fast", 0, {}, false}, slow{"slow", 1, {}, true}, lost{"lost", 1, {}, false};
  result.frozen = {{fast, {{0, 0, 1, 1}, {10, 0.01, 0.05, 1e-4}, {20, 0.02, 0.0005, 1e-4}}, 2, ""},
                   {slow, {{0, 0, 1, 1}, {100, 0.1, 0.05, 0.5}, {300, 0.3, 0.005, 0.4}}, 0, ""},
                   {lost, {{0, 0, 1, 1}, {5, 0.1, 1e9, 1e9}}, 0, "diverged after 5 steps"}};
  const std::string text = markdown(result);
  EXPECT_NE(
      text.find("| fast | 10 | 10.0 | 10.0 | 20 | 20.0 | 15.0 | 20 | 20.0 | > 15.0 | 5.0e-04, timestep cut 2 times |"),
      std::string::npos)
      << text;
  EXPECT_NE(text.find("| slow (the measure) | 100 | 100 | 1.00 | 300 | 300 | 1.00 | - | - | - |"), std::string::npos)
      << text;
  EXPECT_NE(text.find("diverged after 5 steps"), std::string::npos);
  const std::string csv = frozen_csv(result);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 3 + 3 + 2);
  const Plot against_time = frozen_plot(result, false, false), against_steps = frozen_plot(result, true, true);
  ASSERT_EQ(against_time.series.size(), 3u);
  EXPECT_EQ(against_time.series[0].x[1], 0.01);
  EXPECT_EQ(against_steps.series[0].x[1], 10);
  EXPECT_EQ(against_steps.series[1].y[2], 0.4);
  EXPECT_TRUE(std::isnan(against_time.series[2].y[1]));  // outside of the plot
}

}  // namespace
}  // namespace simplexseg
