// SPDX-License-Identifier: Apache-2.0
// A trace records a run, stays small, and does not change the run.
#include "session/run_trace.h"

#include <algorithm>
#include <sstream>

#include "image/mask.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

RunTrace trace_of(Session& session, int steps, int max_samples, bool with_reference) {
  RunTrace trace(max_samples);
  if (with_reference) {
    const Mask truth = mask_of(phantom("sphere", 100, 10).labels, 1);
    trace.set_reference(session.scene().meshes[0].id, std::make_shared<SurfaceError>(truth));
  }
  trace.sample(session, 0);
  for (int done = 0; done < steps; done += 10) {
    session.advance_steps(10);
    if (trace.due(session.total_steps())) trace.sample(session, 0.01 * static_cast<double>(session.total_steps()));
  }
  return trace;
}

TEST(RunTrace, FollowsAMeshUntilItSettles) {
  const auto session = open_session();
  const RunTrace trace = trace_of(*session, 300, 200, true);
  ASSERT_EQ(trace.meshes().size(), 1u);
  const MeshTrace& mesh = trace.meshes()[0];
  EXPECT_EQ(mesh.name, "ball");
  ASSERT_EQ(mesh.samples.size(), 31u);
  const TraceSample &first = mesh.samples.front(), &last = mesh.samples.back();
  EXPECT_EQ(first.steps, 0);
  EXPECT_EQ(first.vertices, 320);
  EXPECT_EQ(last.steps, 300);
  EXPECT_EQ(last.vertices, 1280);
  EXPECT_DOUBLE_EQ(last.seconds, 3);
  EXPECT_GT(mesh.samples[1].residual_mm, 2 * last.residual_mm);
  EXPECT_GT(mesh.samples[1].mean_move_mm, 2 * last.mean_move_mm);
  ASSERT_TRUE(first.error && last.error);
  EXPECT_GT(first.error->mean_mm, 2 * last.error->mean_mm);
  EXPECT_LT(last.error->mean_mm, 1.5);
}

TEST(RunTrace, StaysSmallAndKeepsItsFirstSample) {
  const auto session = open_session();
  const RunTrace trace = trace_of(*session, 900, 20, false);
  const auto& samples = trace.meshes()[0].samples;
  EXPECT_LE(samples.size(), 20u);
  EXPECT_GE(samples.size(), 10u);
  EXPECT_EQ(samples[0].steps, 0);
  EXPECT_GT(samples.back().steps, 800);
  for (std::size_t s = 1; s < samples.size(); ++s) EXPECT_GT(samples[s].steps, samples[s - 1].steps);
}

TEST(RunTrace, SamplingChangesNothingAndReadsNoPoseWithoutAReference) {
  const auto watched = open_session(), alone = open_session();
  trace_of(*watched, 200, 50, true);
  for (int done = 0; done < 200; done += 10) alone->advance_steps(10);
  EXPECT_TRUE(same_state(state_of(*watched), state_of(*alone)));
  const auto session = open_session();
  session->advance_steps(10);
  const auto pose = session->scene_without_poses().meshes[0].mesh.positions;
  RunTrace trace;
  trace.sample(*session, 1);
  EXPECT_EQ(session->scene_without_poses().meshes[0].mesh.positions, pose);
}

TEST(RunTrace, PlotsOverStepsMarkARefinement) {
  const auto session = open_session();
  const RunTrace trace = trace_of(*session, 300, 200, true);
  const std::vector<TraceSample>& samples = trace.meshes()[0].samples;
  const Plot by_steps = trace.residual_plot(TraceAxis::Steps), errors = trace.error_plot(TraceAxis::Steps);
  EXPECT_EQ(by_steps.series[0].x[7], static_cast<double>(samples[7].steps));
  EXPECT_EQ(errors.series[0].x[7], static_cast<double>(samples[7].steps));
  EXPECT_NE(by_steps.x_title, trace.residual_plot().x_title);
  const auto refined =
      std::find_if(samples.begin(), samples.end(), [](const TraceSample& s) { return s.vertices == 1280; });
  ASSERT_NE(refined, samples.end());
  ASSERT_EQ(by_steps.series.size(), 2u);
  const PlotSeries& marks = by_steps.series[1];
  EXPECT_TRUE(marks.markers);
  EXPECT_TRUE(marks.name.empty());
  EXPECT_EQ(marks.x[0], static_cast<double>(refined->steps));
}

TEST(RunTrace, PlotsAndCsvContainEachSample) {
  const auto session = open_session();
  RunTrace trace = trace_of(*session, 50, 200, true);
  EXPECT_TRUE(trace.has_errors());
  const Plot residual = trace.residual_plot(), error = trace.error_plot();
  ASSERT_EQ(residual.series.size(), 1u);
  ASSERT_EQ(error.series.size(), 2u);
  EXPECT_EQ(residual.series[0].y.size(), 6u);
  EXPECT_EQ(error.series[1].y[3], trace.meshes()[0].samples[3].error->p95_mm);
  EXPECT_NE(error.series[0].name.find("ball"), std::string::npos);
  const std::string csv = trace.csv();
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) EXPECT_EQ(std::count(line.begin(), line.end(), ','), 8) << line;
  trace.clear();
  EXPECT_TRUE(trace.meshes().empty());
  EXPECT_TRUE(trace.due(0));
  session->apply(AddMesh{"left, \"half\"", {{2, 0, 0}, 5}, {}, {}});
  trace.sample(*session, 0);
  EXPECT_EQ(trace.meshes().size(), 2u);
  EXPECT_NE(trace.csv().find("\"left, \"\"half\"\"\""), std::string::npos) << trace.csv();
  EXPECT_NE(trace.csv().find(",,\n"), std::string::npos);  // without a reference
  EXPECT_EQ(trace.error_plot().series.size(), 2u);
}

}  // namespace
}  // namespace simplexseg
