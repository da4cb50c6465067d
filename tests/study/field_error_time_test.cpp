// SPDX-License-Identifier: Apache-2.0
#include "study/field_error_time.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "field/evidence_field.h"
#include "field/make_field_solver.h"
#include "study/field_trials.h"

namespace simplexseg {
namespace {

FieldTrial noisy_ball() {
  FieldNoise noise;
  return trial_with(usual_grid(), ball,
                    [&](const Eigen::Vector3d& p, bool in) { return usual_value(p, in) + 40 * noise.normal(); });
}
const std::vector<Mark>& marks() {
  static const std::vector<Mark> all{usual_seed(), outside_mark({0, 18, 0}, 2), inside_mark({0, 10, 0}, 2)};
  return all;
}

TEST(FieldErrorTime, VariantsDifferFromTheDefaultInOneSetting) {
  std::set<std::string> names;
  for (const FieldVariant& variant : field_variants()) {
    EXPECT_TRUE(names.insert(variant.name).second) << variant.name;
    const EvidenceSettings &s = variant.settings, d;
    const int changed =
        (s.tolerance != d.tolerance) + (s.most_iterations != d.most_iterations) + (s.max_cells != d.max_cells);
    EXPECT_LE(changed, 1) << variant.name;
  }
  EXPECT_TRUE(names.contains("default"));
}

// The curve has the results of a field that gets the same marks.
TEST(FieldErrorTime, ACurveHasTheAgreementAfterEachMark) {
  const FieldTrial trial = noisy_ball();
  FieldVariant coarse{"cells at most 2000", "cells at most", {}};
  coarse.settings.max_cells = 2000;
  const FieldCurve fine_curve = measure_field(trial.volume, *trial.truth, marks(), {"default", "default", {}},
                                              run_serially(), make_cpu_field_solver, wall_seconds),
                   coarse_curve = measure_field(trial.volume, *trial.truth, marks(), coarse, run_serially(),
                                                make_cpu_field_solver, processor_seconds);
  ASSERT_EQ(fine_curve.samples.size(), marks().size());
  EvidenceField field(trial.volume);
  for (std::size_t count = 1; count <= marks().size(); ++count) {
    field.update({marks().data(), count});
    const FieldSample& sample = fine_curve.samples[count - 1];
    EXPECT_EQ(sample.dice, dice(*trial.truth, field.object())) << count;
    EXPECT_EQ(sample.cells, field.box().voxel_count());
    EXPECT_EQ(sample.iterations, field.report().iterations);
    EXPECT_GT(sample.seconds, 0);
    EXPECT_LT(sample.mean_mm, 1);
  }
  EXPECT_LE(coarse_curve.samples.back().cells, 2000u);
  EXPECT_LT(coarse_curve.samples.back().dice, fine_curve.samples.back().dice);
}

TEST(FieldErrorTime, ClocksCountSeconds) {
  const double wall = wall_seconds(), processor = processor_seconds();
  while (processor_seconds() - processor < 0.02) {
  }
  EXPECT_GE(wall_seconds() - wall, 0.015);
  EXPECT_LT(wall_seconds() - wall, 10);
}

TEST(FieldErrorTime, TheSolverConvergesToItsLastSolution) {
  const FieldTrial trial = noisy_ball();
  const auto solver = measure_solver(trial.volume, marks(), run_serially(), make_cpu_field_solver);
  ASSERT_EQ(solver.size(), marks().size());
  for (const std::vector<SolverSample>& samples : solver) {
    ASSERT_GT(samples.size(), 5u);
    for (std::size_t s = 0; s < samples.size(); ++s) EXPECT_EQ(samples[s].iterations, static_cast<int>(s) + 1);
    EXPECT_EQ(samples.back().error, 0);
    EXPECT_LT(samples.back().estimated, 1e-3);
    EXPECT_LT(samples[samples.size() / 2].error, 0.01);
  }
  EXPECT_GT(solver.front().front().error, solver.front()[5].error);
}

TEST(FieldErrorTime, TheRobotPlacesASeedAndClicks) {
  const FieldTrial trial = noisy_ball();
  const std::vector<RobotClick> clicks =
      robot_clicks(trial.volume, *trial.truth, 2, run_serially(), make_cpu_field_solver);
  ASSERT_GE(clicks.size(), 2u);
  EXPECT_EQ(clicks.front().mark.kind, MarkKind::Inside);
  EXPECT_LT(clicks.front().mark.position_mm.norm(), 2);
}

TEST(FieldErrorTime, ReportsContainAllSamples) {
  FieldErrorTime one{"kidney, left", "CPU, 1 thread", marks(), {}, {}};
  one.curves.push_back({{"default", "default", {}}, {{2, 0.8, 1.5, 1000, 5, 1}, {0.5, 0.9, 0.7, 1000, 3, 0}}});
  one.curves.push_back({{"tolerance 0.1", "tolerance", {}}, {{1, 0.7, 2.5, 1000, 2, 1}, {0.4, 0.8, 1, 1000, 1, 0}}});
  one.solver = {{{1, 0.5, 0.4}, {2, 0.02, 0.03}, {3, 0.04, 0.009}, {4, 0.005, 0.001}}};
  const std::string csv = field_curves_csv({one}), solver = field_solver_csv({one}),
                    text = field_error_time_report(one);
  EXPECT_EQ(std::ranges::count(csv, '\n'), 5);
  EXPECT_NE(csv.find("\"kidney, left\",\"CPU, 1 thread\",tolerance,tolerance 0.1,1,0.4,0.80000,1,1000,1,0\n"),
            std::string::npos)
      << csv;
  EXPECT_EQ(std::ranges::count(solver, '\n'), 5);
  EXPECT_NE(text.find("| default | 1000 | 2.00 | 5 | 0.8000 | 1.500 | 0.500 | 0.9000 | 0.700 |"), std::string::npos)
      << text;
  // 0.03 is reached after 4 cycles, because the error is larger again after 3.
  EXPECT_NE(text.find("| seed | 2 | 4 | 4 | - | - | 3 | 0.04 |"), std::string::npos) << text;
  const Plot plot = field_plot(one, false, true);
  ASSERT_EQ(plot.series.size(), 2u);
  EXPECT_EQ(plot.series[1].x, std::vector<double>{0.4});
  EXPECT_NEAR(plot.series[1].y[0], 0.2, 1e-12);
  EXPECT_EQ(field_solver_plot(one).series.size(), 2u);
}

}  // namespace
}  // namespace simplexseg
