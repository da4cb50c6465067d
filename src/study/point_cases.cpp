// SPDX-License-Identifier: Apache-2.0
// Stability cases: attraction points at extreme positions.
#include <cmath>

#include "study/trials.h"

namespace simplexseg {
namespace {

Trial ball_with_points(std::initializer_list<Eigen::Vector3d> points) {
  Trial trial = ball_trial();
  trial.scene.meshes[0].mesh = make_sphere({0, 0, 0}, kBallRadius, 2);
  for (const Eigen::Vector3d& point : points) add_point(trial, point);
  trial.folds = true;
  return trial;
}

StabilityCase refused_point(const char* name, const char* what, const Eigen::Vector3d& position) {
  return {name,
          what,
          CaseOutcome::Refused,
          CaseOutcome::Refused,
          "a float could not hold what comes of it",
          [=](bool) { return ball_with_points({position}); },
          "not a finite number within"};
}

}  // namespace

std::vector<StabilityCase> point_cases() {
  std::vector<StabilityCase> cases;
  cases.push_back(
      {"point_at_1e6_mm", "an attraction point a kilometre away", CaseOutcome::Bounded, CaseOutcome::Bounded,
       "the patch goes where it is pulled, not farther; folds, and steps undone for them, are reported", [](bool) {
         Trial trial = ball_with_points({{1e6, 0, 0}});
         trial.reach_mm = 1.1e6;
         trial.inverted = true, trial.cuts = true;
         return trial;
       }});
  cases.push_back(refused_point("point_at_2e9_mm", "an attraction point 2e9 mm away", {2e9, 0, 0}));
  cases.push_back(refused_point("point_nan", "an attraction point that is not a number", {NAN, 0, 0}));
  cases.push_back({"points_200_on_one_vertex", "200 attraction points, one nearest vertex", CaseOutcome::Converges,
                   CaseOutcome::Converges, "their mean pulls as one: a vertex within 0.5 mm of it", [](bool) {
                     Trial trial = ball_with_points({});
                     const Eigen::Vector3d p = trial.scene.meshes[0].mesh.positions[7].cast<double>();
                     for (int k = 0; k < 200; ++k) add_point(trial, (1.1 + 1e-4 * k) * p);
                     trial.error = distance_to((1.1 + 1e-4 * 99.5) * p);
                     trial.tolerance = 0.5;
                     return trial;
                   }});
  cases.push_back({"points_against_each_other", "two points, one inside and one outside, on one vertex",
                   CaseOutcome::Converges, CaseOutcome::Converges, "to the ball's surface within 2 mm: they cancel out",
                   [](bool) {
                     Trial trial = ball_with_points({});
                     const Eigen::Vector3d p = trial.scene.meshes[0].mesh.positions[7].cast<double>();
                     add_point(trial, 0.9 * p), add_point(trial, 1.1 * p);
                     trial.tolerance = 2;
                     return trial;
                   }});
  cases.push_back({"point_on_its_vertex", "a point exactly where the vertex is", CaseOutcome::Converges,
                   CaseOutcome::Converges, "to the start within 1 mm: a pull of 0", [](bool) {
                     Trial trial = ball_with_points({});
                     add_point(trial, trial.scene.meshes[0].mesh.positions[7].cast<double>());
                     trial.error = distance_from(trial.scene.meshes[0].mesh);
                     return trial;
                   }});
  cases.push_back(
      {"point_moved_every_step", "a point that jumps 40 mm at each step", CaseOutcome::Bounded, CaseOutcome::Bounded,
       "each step is bounded by the point's distance; folds are reported", [](bool) {
         Trial trial = ball_with_points({{20, 0, 0}});
         trial.chunk = 1, trial.steps = 200;
         trial.between = [](Session& session, int n) {
           const double angle = 2.4 * n;
           session.apply(MovePoint{100, {20 * std::cos(angle), 20 * std::sin(angle), 10 * std::cos(0.7 * n)}, n > 1});
         };
         return trial;
       }});
  cases.push_back(
      {"points_inside", "six points near the centre, each with a patch of 10 rings", CaseOutcome::Bounded,
       CaseOutcome::Bounded, "the patches meet in the middle; whatever is folded or inside out is reported", [](bool) {
         Trial trial = ball_with_points({{3, 0, 0}, {-3, 0, 0}, {0, 3, 0}, {0, -3, 0}, {0, 0, 3}, {0, 0, -3}});
         set_value(trial.scene.meshes[0].parameters, {"attraction", "weight", 20});
         set_value(trial.scene.meshes[0].parameters, {"attraction", "order", 10});
         trial.inverted = true;
         return trial;
       }});
  return cases;
}

}  // namespace simplexseg
