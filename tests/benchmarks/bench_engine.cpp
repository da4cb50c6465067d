// SPDX-License-Identifier: Apache-2.0
// Time of a step by size, forces, backend and threads. The counter ns_per_vertex is the figure of docs/results/.
//   bench_engine --benchmark_filter=internal     see --help for the rest
#include <benchmark/benchmark.h>

#include "core/force_list.h"
#include "core/phantom.h"
#include "core/region_model.h"
#include "core/shape_reference.h"
#include "gpu/backend.h"

namespace simplexseg {
namespace {

enum class Load { Internal, Gradient, Region };

ForceParameters forces_for(Load load) {
  ForceParameters p = default_force_parameters();
  auto set = [&](ForceId force, int parameter, float value) { p.values[static_cast<int>(force)][parameter] = value; };
  for (int f = 0; f < kForceCount; ++f) p.values[f][0] = 0;
  set(ForceId::Smoothing, 0, 0.5f);
  set(ForceId::Smoothing, SmoothingForce::curvature, 1);     // keeps its volume: a sphere that vanishes computes with denormals
  set(ForceId::ShapeMemory, 0, 0.2f);
  if (load == Load::Gradient) {
    set(ForceId::Gradient, 0, 0.5f);
    set(ForceId::Gradient, GradientForce::samples, 6);       // 13 samples
    set(ForceId::Gradient, GradientForce::object, 1);
  }
  if (load == Load::Region) set(ForceId::Region, 0, 0.5f);
  return p;
}

const Volume& phantom() {
  static const Volume volume = [] {
    PhantomSettings settings;
    settings.size = 128;
    settings.noise_sigma = 10;
    return make_phantom("sphere", settings).image;
  }();
  return volume;
}

/// arguments: vertices (rounded up to a sphere), threads (0: CUDA)
void step(benchmark::State& state, Load load, int refresh_interval) {
  const int level = sphere_level_for(static_cast<int>(state.range(0)));
  const int threads = static_cast<int>(state.range(1));
  if (threads == 0 && !why_no_cuda().empty()) {
    state.SkipWithError("no CUDA device");
    return;
  }
  const SimplexMesh mesh = make_sphere(phantom().geometry().centre_mm(), 35, level);
  const std::vector<Vec4> shape = shape_reference_of(mesh);
  EngineMesh item;
  item.positions = item.previous = mesh.positions;
  item.neighbours = mesh.neighbours, item.shape = shape, item.parameters = forces_for(load);
  const RegionModel region = estimate_region(phantom(), mesh, 20);
  if (load == Load::Region) item.region = &region;
  SimulationParameters simulation = default_simulation_parameters();
  simulation.refresh_interval = static_cast<float>(refresh_interval);
  const auto engine = threads == 0 ? make_cuda_engine() : make_cpu_engine(threads);
  engine->set_volume(phantom());
  engine->load({&item, 1}, simulation);
  const int steps = std::max(1, 200'000 / mesh.vertex_count());
  engine->step(steps);
  for (auto _ : state) engine->step(steps);
  const double vertex_steps = static_cast<double>(state.iterations()) * steps * mesh.vertex_count();
  state.counters["vertices"] = mesh.vertex_count();
  state.counters["ns_per_vertex"] = benchmark::Counter(vertex_steps * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations()) * steps * 1e-6, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"vertices", "threads"})->UseRealTime()->Unit(benchmark::kMillisecond);
  for (int threads : {1, 2, 0})
    for (int vertices : {20, 320, 1280, 20480, 81920, 327680, 1310720}) b->Args({vertices, threads});
}

BENCHMARK_CAPTURE(step, internal, Load::Internal, 1)->Apply(sizes);
BENCHMARK_CAPTURE(step, gradient_13_samples_every_step, Load::Gradient, 1)->Apply(sizes);
BENCHMARK_CAPTURE(step, region_every_third_step, Load::Region, 3)->Apply(sizes);

}  // namespace
}  // namespace simplexseg

BENCHMARK_MAIN();
