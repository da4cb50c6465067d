// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/error.h"
#include "forces/region_model.h"
#include "mesh/shape_reference.h"
#include "session/engine_scene.h"
#include "step/simulation_parameters.h"
#include "study/mesh_check.h"
#include "study/stability_case.h"

namespace simplexseg {
namespace {

/// Result of a trial: messages of the program, number of steps, final scene and last measurements.
struct TrialRun {
  std::optional<std::string> refusal, failure;
  std::vector<std::string> cuts;
  int steps = 0;
  Scene end;
  StepOutcome outcome;
};

TrialRun run_in_session(const Trial& trial, const EngineFactory& make_engine) {
  TrialRun run;
  Session session(make_engine());
  try {
    session.open(trial.scene, trial.volume);
    const int chunk = trial.chunk > 0 ? trial.chunk : trial.steps;
    for (int chunks = 1; run.steps < trial.steps && !run.failure; ++chunks) {
      const Advance part = session.advance_steps(std::min(chunk, trial.steps - run.steps));
      run.steps += part.steps;
      run.cuts.insert(run.cuts.end(), part.cuts.begin(), part.cuts.end());
      run.failure = part.failure;
      if (part.steps == 0) break;
      // `between` is not called after the last step: its commands may reload the meshes and discard the measurements.
      if (run.steps < trial.steps && trial.between) trial.between(session, chunks);
    }
  } catch (const Error& error) {
    run.refusal = error.what();
  }
  run.end = session.scene();
  run.outcome = session.last_outcome();
  return run;
}

TrialRun run_in_engine(const Trial& trial, const EngineFactory& make_engine) {
  TrialRun run;
  run.end = trial.scene;
  const std::unique_ptr<Engine> engine = make_engine();
  try {
    engine->set_volume(trial.volume);
    std::vector<EngineMesh> meshes;
    for (MeshItem& item : run.end.meshes) {
      item.previous = item.mesh.positions;
      if (item.shape.empty()) item.shape = shape_reference_of(item.mesh);
      item.region = estimate_region(trial.volume, item.mesh, 2 * item.seed.radius_mm);
      EngineMesh m;
      m.positions = item.mesh.positions, m.previous = item.previous, m.neighbours = item.mesh.neighbours;
      m.shape = item.shape, m.profiles = item.profiles, m.region = &item.region, m.parameters = item.parameters;
      meshes.push_back(m);
    }
    engine->load(meshes, run.end.simulation);
    engine->set_points(engine_points(run.end));
    run.outcome = engine->step(trial.steps);
    run.steps = run.outcome.steps;
    for (const TimestepCut& cut : run.outcome.cuts)
      run.cuts.push_back("mesh '" + run.end.meshes[cut.failure.mesh].name + "': force " +
                         force_list()[static_cast<int>(cut.failure.force)].name);
    if (const auto& failure = run.outcome.failure)
      run.failure = "mesh '" + run.end.meshes[failure->mesh].name + "': force " +
                    force_list()[static_cast<int>(failure->force)].name;
    for (std::size_t k = 0; k < run.end.meshes.size(); ++k)
      engine->read(static_cast<int>(k), run.end.meshes[k].mesh.positions, run.end.meshes[k].previous);
  } catch (const Error& error) {
    run.refusal = error.what();
  }
  return run;
}

bool names_mesh_and_force(const std::string& line, const Scene& scene) {
  const bool mesh = std::any_of(scene.meshes.begin(), scene.meshes.end(),
                                [&](const MeshItem& item) { return line.find(item.name) != std::string::npos; });
  const auto forces = force_list();
  return mesh && std::any_of(forces.begin(), forces.end(),
                             [&](const ForceInfo& force) { return line.find(force.name) != std::string::npos; });
}

/// Fault that makes the case fail, regardless of the expected outcome; empty: none. Stores the measurements of the
/// final meshes in `result`.
std::string find_fault(const TrialRun& run, const Trial& trial, CaseResult& result) {
  std::ostringstream fault;
  for (std::size_t k = 0; k < run.end.meshes.size(); ++k) {
    const MeshItem& item = run.end.meshes[k];
    if (!all_finite(item.mesh)) return "a position is not finite";
    const SimplexMesh before{item.previous, item.mesh.neighbours};
    const int folds = count_folds(item.mesh), reported_folds = run.outcome.folded_vertices[k];
    const bool inverted = is_inverted(item.mesh, 0.01), reported_inverted = run.outcome.inverted[k];
    result.folded += folds, result.folded_reported += reported_folds;
    result.inverted = result.inverted || inverted, result.inverted_reported |= reported_inverted;
    result.farthest_mm =
        std::max(result.farthest_mm, farthest_from(item.mesh, mean_position(trial.scene.meshes[k].mesh)));
    // The engine counts folds at the positions before its last step. It must report folds that clearly exist at these
    // positions and still exist after the step.
    if (reported_folds == 0 && folds > 0 && count_folds(before, 0.05) > 0)
      fault << folds << " folded vertices are not reported";
    else if (inverted && !reported_inverted)
      fault << "an inverted mesh is not reported";
    else if (folds > 0 && !trial.folds)
      fault << folds << " folded vertices remain";
    else if (inverted && !trial.inverted)
      fault << "a mesh is inverted";
    if (fault.tellp() > 0) return fault.str();
  }
  if (result.farthest_mm > trial.reach_mm)
    fault << "a vertex is " << result.farthest_mm << " mm from the initial centre of its mesh, more than "
          << trial.reach_mm << " mm";
  return fault.str();
}

}  // namespace

const char* to_string(CaseOutcome outcome) {
  switch (outcome) {
    case CaseOutcome::Converges:
      return "converges";
    case CaseOutcome::Bounded:
      return "bounded";
    case CaseOutcome::Cut:
      return "cut";
    case CaseOutcome::Pauses:
      return "pauses";
    case CaseOutcome::Refused:
      return "refused";
    case CaseOutcome::Fails:
      break;
  }
  return "fails";
}

std::vector<std::string> solver_names() {
  std::istringstream choices(simulation_table()[find_parameter(simulation_table(), "solver")].choices);
  std::vector<std::string> names;
  for (std::string name; std::getline(choices, name, '|');) names.push_back(name);
  return names;
}

CaseResult run_case(const StabilityCase& stability_case, Solver solver, const EngineFactory& make_engine, bool full) {
  Trial trial = stability_case.make(full);
  trial.scene.simulation.solver_choice = static_cast<float>(solver);
  const TrialRun run = trial.at_engine ? run_in_engine(trial, make_engine) : run_in_session(trial, make_engine);
  const CaseOutcome stated = solver == Solver::Verlet ? stability_case.stated_verlet : stability_case.stated;
  CaseResult result;
  result.steps = run.steps, result.cuts = static_cast<int>(run.cuts.size());
  if (run.refusal) {
    result.note = *run.refusal;
    if (stability_case.refusal_text.empty() || result.note.find(stability_case.refusal_text) != std::string::npos)
      result.outcome = CaseOutcome::Refused;
  } else if (const std::string fault = find_fault(run, trial, result); !fault.empty()) {
    result.note = fault;
    if (run.failure) result.note += "; paused: " + *run.failure;
    if (!run.cuts.empty()) result.note += "; cut: " + run.cuts.front();
  } else if (run.failure) {
    result.note = *run.failure;
    if (names_mesh_and_force(result.note, run.end)) result.outcome = CaseOutcome::Pauses;
  } else if (run.steps != trial.steps) {
    result.note = "the run stopped after " + std::to_string(run.steps) + " steps without a message";
  } else if (!run.cuts.empty() && !trial.cuts) {
    result.note = run.cuts.front();
    if (names_mesh_and_force(result.note, run.end)) result.outcome = CaseOutcome::Cut;
  } else {
    if (trial.error) result.error = trial.error(run.end);
    result.outcome = result.error <= trial.tolerance ? CaseOutcome::Converges : CaseOutcome::Bounded;
  }
  result.as_stated =
      result.outcome == stated || (stated == CaseOutcome::Bounded && result.outcome == CaseOutcome::Converges);
  return result;
}

std::span<const StabilityCase> stability_cases() {
  static const std::vector<StabilityCase> all = [] {
    std::vector<StabilityCase> list;
    for (auto part : {force_cases, setting_cases, mesh_cases, volume_cases, point_cases})
      for (StabilityCase& one : part()) list.push_back(std::move(one));
    return list;
  }();
  return all;
}

}  // namespace simplexseg
