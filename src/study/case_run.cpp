// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/error.h"
#include "forces/region_model.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"
#include "study/mesh_check.h"
#include "study/stability_case.h"

namespace simplexseg {
namespace {

/// What the program said while the trial ran, and the poses it ended with.
struct Said {
  std::optional<std::string> refusal, failure;
  std::vector<std::string> cuts;
  int steps = 0;
  Scene end;
  StepOutcome outcome;
};

Said run_in_session(const Trial& trial, const EngineFactory& make_engine) {
  Said said;
  Session session(make_engine());
  try {
    session.open(trial.scene, trial.volume);
    const int chunk = trial.chunk > 0 ? trial.chunk : trial.steps;
    for (int chunks = 1; said.steps < trial.steps && !said.failure; ++chunks) {
      const Advance part = session.advance_steps(std::min(chunk, trial.steps - said.steps));
      said.steps += part.steps;
      said.cuts.insert(said.cuts.end(), part.cuts.begin(), part.cuts.end());
      said.failure = part.failure;
      if (part.steps == 0) break;
      // What was measured is of the steps: a command may load the meshes anew.
      if (said.steps < trial.steps && trial.between) trial.between(session, chunks);
    }
  } catch (const Error& error) {
    said.refusal = error.what();
  }
  said.end = session.scene();
  said.outcome = session.last_outcome();
  return said;
}

Said run_in_engine(const Trial& trial, const EngineFactory& make_engine) {
  Said said;
  said.end = trial.scene;
  const std::unique_ptr<Engine> engine = make_engine();
  try {
    engine->set_volume(trial.volume);
    std::vector<EngineMesh> meshes;
    for (MeshItem& item : said.end.meshes) {
      item.previous = item.mesh.positions;
      if (item.shape.empty()) item.shape = shape_reference_of(item.mesh);
      item.region = estimate_region(trial.volume, item.mesh, 2 * item.seed.radius_mm);
      EngineMesh m;
      m.positions = item.mesh.positions, m.previous = item.previous, m.neighbours = item.mesh.neighbours;
      m.shape = item.shape, m.profiles = item.profiles, m.region = &item.region, m.parameters = item.parameters;
      meshes.push_back(m);
    }
    engine->load(meshes, said.end.simulation);
    std::vector<EnginePoint> points;
    for (const UserPoint& point : said.end.points)
      for (std::size_t k = 0; k < said.end.meshes.size(); ++k)
        if (said.end.meshes[k].id == point.mesh) points.push_back({static_cast<int>(k), point.position_mm});
    engine->set_points(points);
    said.outcome = engine->step(trial.steps);
    said.steps = said.outcome.steps;
    for (const TimestepCut& cut : said.outcome.cuts)
      said.cuts.push_back("mesh '" + said.end.meshes[cut.failure.mesh].name + "': force " +
                          force_list()[static_cast<int>(cut.failure.force)].name);
    if (const auto& failure = said.outcome.failure)
      said.failure = "mesh '" + said.end.meshes[failure->mesh].name + "': force " +
                     force_list()[static_cast<int>(failure->force)].name;
    for (std::size_t k = 0; k < said.end.meshes.size(); ++k)
      engine->read(static_cast<int>(k), said.end.meshes[k].mesh.positions, said.end.meshes[k].previous);
  } catch (const Error& error) {
    said.refusal = error.what();
  }
  return said;
}

bool names_mesh_and_force(const std::string& line, const Scene& scene) {
  const bool mesh = std::any_of(scene.meshes.begin(), scene.meshes.end(),
                                [&](const MeshItem& item) { return line.find(item.name) != std::string::npos; });
  const auto forces = force_list();
  return mesh && std::any_of(forces.begin(), forces.end(),
                             [&](const ForceInfo& force) { return line.find(force.name) != std::string::npos; });
}

/// What is wrong whatever was stated; empty: nothing.
std::string fault_of(const Said& said, const Trial& trial, CaseResult& result) {
  std::ostringstream fault;
  for (std::size_t k = 0; k < said.end.meshes.size(); ++k) {
    const MeshItem& item = said.end.meshes[k];
    if (!all_finite(item.mesh)) return "a position is not finite";
    const SimplexMesh before{item.previous, item.mesh.neighbours};
    const int folds = count_folds(item.mesh), said_folds = said.outcome.folded_vertices[k];
    const bool inside_out = is_inside_out(item.mesh, 0.01), said_inside_out = said.outcome.inside_out[k];
    result.folded += folds, result.folded_said += said_folds;
    result.inside_out = result.inside_out || inside_out, result.inside_out_said |= said_inside_out;
    result.farthest_mm =
        std::max(result.farthest_mm, farthest_from(item.mesh, mean_position(trial.scene.meshes[k].mesh)));
    // The engine looks at the normals before its last step: a fold that is there before and after it must be said.
    if (said_folds == 0 && folds > 0 && count_folds(before, 0.05) > 0)
      fault << folds << " folded vertices that are not reported";
    else if (inside_out && !said_inside_out)
      fault << "inside out, not reported";
    else if (folds > 0 && !trial.folds)
      fault << folds << " folded vertices are left";
    else if (inside_out && !trial.inside_out)
      fault << "inside out";
    if (fault.tellp() > 0) return fault.str();
  }
  if (result.farthest_mm > trial.reach_mm)
    fault << "a vertex is " << result.farthest_mm << " mm away, farther than " << trial.reach_mm;
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
  const Said said = trial.at_engine ? run_in_engine(trial, make_engine) : run_in_session(trial, make_engine);
  const CaseOutcome stated = solver == Solver::Verlet ? stability_case.stated_verlet : stability_case.stated;
  CaseResult result;
  result.steps = said.steps, result.cuts = static_cast<int>(said.cuts.size());
  if (said.refusal) {
    result.note = *said.refusal;
    if (stability_case.says.empty() || result.note.find(stability_case.says) != std::string::npos)
      result.outcome = CaseOutcome::Refused;
  } else if (const std::string fault = fault_of(said, trial, result); !fault.empty()) {
    result.note = fault;
    if (said.failure) result.note += "; paused: " + *said.failure;
    if (!said.cuts.empty()) result.note += "; cut: " + said.cuts.front();
  } else if (said.failure) {
    result.note = *said.failure;
    if (names_mesh_and_force(result.note, said.end)) result.outcome = CaseOutcome::Pauses;
  } else if (said.steps != trial.steps) {
    result.note = "it stopped after " + std::to_string(said.steps) + " steps without a word";
  } else if (!said.cuts.empty() && !trial.cuts) {
    result.note = said.cuts.front();
    if (names_mesh_and_force(result.note, said.end)) result.outcome = CaseOutcome::Cut;
  } else {
    if (trial.error) result.error = trial.error(said.end);
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
