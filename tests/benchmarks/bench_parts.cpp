// SPDX-License-Identifier: Apache-2.0
// Cost of each part of a step; shows that unused parts cost nothing.
//   bench_parts [cpu|cuda] [VERTICES]          table: memory, time and launches that each force adds to smoothing
//   bench_parts toggle [cpu|cuda] [VERTICES]   table: delay of the steps when a force's slider leaves or reaches 0
//   bench_parts alone FORCE                    nanoseconds per vertex and step with this force alone, on one thread;
//                                              compares builds with and without the other forces
//                                              (scripts/measure_leaving_out)
//   bench_parts forces                         names of all forces
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>

#include "forces/force_list.h"
#include "forces/profile_reference.h"
#include "forces/region_model.h"
#include "gpu/backend.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"
#include "step/step_needs.h"
#include "study/trials.h"

using namespace simplexseg;

namespace {

struct Cost {
  double us;
  std::map<std::string, std::size_t> bytes;
  std::map<std::string, std::uint64_t> launches;
};

ForceParameters weights_of(unsigned forces) {
  ForceParameters p = default_force_parameters();
  for (const ForceInfo& force : force_list())
    p.values[static_cast<int>(force.id)][0] = (forces >> static_cast<int>(force.id) & 1u) != 0 ? 0.3f : 0.0f;
  return p;
}
SimulationParameters steps_by(Solver solver) {
  SimulationParameters s = default_simulation_parameters();
  s.solver_choice = static_cast<float>(solver);
  return s;
}

/// Loads a mesh with these forces, all of the same weight, and two attraction points.
void load(Engine& engine, unsigned forces, int level, Solver solver) {
  SimplexMesh mesh = make_sphere({0, 0, 0}, kBallRadius, level);
  const ForceParameters p = weights_of(forces);
  const auto shape = shape_reference_of(mesh);
  const auto profiles = profile_reference_of(mesh, ball_volume(), p);
  const RegionModel region = estimate_region(ball_volume(), mesh, 2 * kBallRadius);
  engine.set_volume(ball_volume());
  EngineMesh m;
  m.positions = m.previous = mesh.positions, m.neighbours = mesh.neighbours, m.shape = shape, m.profiles = profiles,
  m.region = &region, m.parameters = p;
  engine.load(std::span(&m, 1), steps_by(solver));
  const std::vector<EnginePoint> points{{0, {22, 0, 0}}, {0, {0, -21, 3}}};
  engine.set_points(points);
}

Cost cost_of(unsigned forces, Engine& engine, int level, Solver solver) {
  load(engine, forces, level, solver);
  engine.step(60);
  Cost cost;
  for (const Engine::AllocatedArray& array : engine.allocated_arrays()) cost.bytes[array.name] = array.bytes;
  for (const Engine::KernelCount& kernel : engine.kernel_counts()) cost.launches[kernel.name] -= kernel.launches;
  std::vector<double> us;
  constexpr int kSteps = 60, kRepeats = 9;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    engine.step(kSteps);
    us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count() / kSteps);
  }
  for (const Engine::KernelCount& kernel : engine.kernel_counts()) cost.launches[kernel.name] += kernel.launches;
  std::erase_if(cost.launches, [](const auto& kernel) { return kernel.second == 0; });
  std::sort(us.begin(), us.end());
  cost.us = us[kRepeats / 2];
  return cost;
}

void row(const char* part, const Cost& with, const Cost& without) {
  std::size_t bytes = 0;
  std::string arrays, kernels;
  for (const auto& [name, size] : with.bytes) {
    const auto before = without.bytes.find(name);
    if (before != without.bytes.end() && before->second == size) continue;
    bytes += size - (before == without.bytes.end() ? 0 : before->second);
    arrays += (arrays.empty() ? "" : ", ") + name;
  }
  for (const auto& [name, launches] : with.launches)
    if (!without.launches.contains(name)) kernels += (kernels.empty() ? "" : ", ") + name;
  std::printf("| %s | %.2f | %s | %+.2f | %s |\n", part, static_cast<double>(bytes) / 1e6, arrays.c_str(),
              with.us - without.us, kernels.c_str());
}

/// Prints by how many milliseconds new weights and ten steps take longer than ten steps: median and largest of several.
void toggle(Engine& engine, unsigned from, unsigned to, const char* what) {
  auto ms_of = [&](auto&& work) {
    const auto start = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
  };
  const ForceParameters before[] = {weights_of(from)}, after[] = {weights_of(to)};
  const SimulationParameters simulation = steps_by(Solver::Automatic);
  std::vector<double> delays;
  constexpr int kRepeats = 11;
  for (int repeat = 0; repeat < kRepeats; ++repeat) {
    engine.set_parameters(before, simulation);
    engine.step(60);
    const double changed = ms_of([&] { engine.set_parameters(after, simulation), engine.step(10); });
    engine.step(60);
    delays.push_back(changed - ms_of([&] { engine.step(10); }));
  }
  std::sort(delays.begin(), delays.end());
  std::printf("| %s | %.2f | %.2f |\n", what, delays[kRepeats / 2], delays.back());
}

}  // namespace

int main(int argc, char** argv) {
  const std::string mode = argc > 1 ? argv[1] : "cpu";
  if (mode == "forces") {
    for (const ForceInfo& force : force_list()) std::printf("%s ", force.name);
    std::printf("\n");
    return 0;
  }
  if (mode == "alone" && argc > 2) {
    const ForceInfo* force = find_force(argv[2]);
    if (force == nullptr) return std::fprintf(stderr, "there is no force '%s'\n", argv[2]), 2;
    const auto engine = make_cpu_engine(1);
    std::printf("%.3f\n", 1000 * cost_of(bit(force->id), *engine, 4, Solver::Verlet).us / 5120);
    return 0;
  }
  if (mode == "toggle") {
    const bool cuda = argc > 2 && std::string(argv[2]) == "cuda";
    const auto engine = cuda ? make_cuda_engine() : make_cpu_engine();
    const int level = sphere_level_for(argc > 3 ? std::atoi(argv[3]) : 20480);
    const unsigned all = (1u << kForceCount) - 1;
    load(*engine, all, level, Solver::Automatic);
    engine->step(100);
    std::printf("%d vertices, %s\n\n| slider | delay, ms | at most |\n|---|---|---|\n", 20 << (2 * level),
                engine->backend());
    for (const ForceInfo& force : force_list()) {
      toggle(*engine, all, all & ~bit(force.id), (std::string(force.name) + " reaches 0").c_str());
      toggle(*engine, all & ~bit(force.id), all, (std::string(force.name) + " leaves 0").c_str());
    }
    return 0;
  }
  const int level = sphere_level_for(argc > 2 ? std::atoi(argv[2]) : 20480);
  auto cost = [&](unsigned forces, Solver solver) {
    const auto engine = mode == "cuda" ? make_cuda_engine() : make_cpu_engine();
    return cost_of(forces, *engine, level, solver);
  };
  const unsigned base = bit(ForceId::Smoothing);
  const Cost plain = cost(base, Solver::Verlet);
  std::printf(
      "%d vertices, %s; smoothing alone: %.2f us a step\n\n| part | MB | arrays | us a step | kernels "
      "|\n|---|---|---|---|---|\n",
      20 << (2 * level), mode.c_str(), plain.us);
  for (const ForceInfo& force : force_list())
    if (force.id != ForceId::Smoothing) row(force.name, cost(base | bit(force.id), Solver::Verlet), plain);
  row("solver damped", cost(base | bit(ForceId::Evidence), Solver::Damped),
      cost(base | bit(ForceId::Evidence), Solver::Verlet));
  row("solver multigrid", cost(base | bit(ForceId::Evidence), Solver::Multigrid),
      cost(base | bit(ForceId::Evidence), Solver::Verlet));
  return 0;
}
