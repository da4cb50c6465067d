// SPDX-License-Identifier: Apache-2.0
// Cases of the stability study (src/study/) at the size of tests: each with every solver, on every backend.
#include "study/stability_case.h"

#include "step/simulation_parameters.h"
#include "study/trials.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class StabilityCases : public ::testing::TestWithParam<std::tuple<std::string, int>> {};

TEST_P(StabilityCases, EndsAsStated) {
  const auto& [backend, index] = GetParam();
  if (backend == "cuda" && !cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  const StabilityCase& one = stability_cases()[index];
  const auto make = [&backend = backend] { return backend == "cuda" ? make_cuda_engine() : make_cpu_engine(1); };
  const std::vector<std::string> solvers = solver_names();
  for (std::size_t s = 0; s < solvers.size(); ++s) {
    const CaseResult result = run_case(one, static_cast<Solver>(s), make, false);
    EXPECT_TRUE(result.as_stated) << one.name << ", " << solvers[s] << ": " << to_string(result.outcome)
                                  << " instead of "
                                  << to_string(s == static_cast<std::size_t>(Solver::Verlet) ? one.stated_verlet
                                                                                             : one.stated)
                                  << ": " << result.note << " (error " << result.error << ", farthest "
                                  << result.farthest_mm << " mm, folds " << result.folded << ")";
  }
}

TEST(StabilityCase, MarksOfATrialAtTheEngineDoNotAttract) {
  for (const MarkKind kind : {MarkKind::Boundary, MarkKind::Inside, MarkKind::Outside}) {
    const StabilityCase one{"marks", "", CaseOutcome::Converges, CaseOutcome::Converges, "", [kind](bool) {
                              Trial trial = ball_trial();
                              trial.at_engine = true;
                              trial.steps = 20;
                              trial.folds = trial.cuts = true;
                              trial.scene.meshes[0].parameters = forces_with({{"attraction", "weight", 2}});
                              add_point(trial, {25, 0, 0});
                              trial.scene.points.back().kind = kind;
                              trial.error = distance_from(trial.scene.meshes[0].mesh);
                              trial.tolerance = 100;
                              return trial;
                            }};
    const CaseResult result = run_case(
        one, Solver::Verlet, [] { return make_cpu_engine(1); }, false);
    if (kind == MarkKind::Boundary)
      EXPECT_GT(result.error, 0.5) << result.note;
    else
      EXPECT_EQ(result.error, 0) << result.note;
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, StabilityCases,
                         ::testing::Combine(::testing::Values("cpu", "cuda"),
                                            ::testing::Range(0, static_cast<int>(stability_cases().size()))),
                         [](const auto& info) {
                           std::string name =
                               std::get<0>(info.param) + "_" + stability_cases()[std::get<1>(info.param)].name;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

}  // namespace
}  // namespace simplexseg
