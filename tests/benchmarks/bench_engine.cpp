// SPDX-License-Identifier: Apache-2.0
// Time of a step by size, forces, backend and threads. docs/results/ shows the counter ns_per_vertex.
//   bench_engine --benchmark_filter=internal     --help lists the other options
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "forces/force_list.h"
#include "forces/region_model.h"
#include "geodesic.h"
#include "gpu/backend.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "step/simulation_parameters.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

enum class Load { Internal, Gradient, AnyGradient, Field, Region, FullGradient, FullProfile };

ForceParameters forces_for(Load load) {
  ForceParameters p = default_force_parameters();
  auto set = [&](ForceId force, int parameter, float value) { p.values[static_cast<int>(force)][parameter] = value; };
  for (int f = 0; f < kForceCount; ++f) p.values[f][0] = 0;
  set(ForceId::Smoothing, 0, 0.5f);
  set(ForceId::Smoothing, SmoothingForce::curvature,
      1);  // keeps its volume: a sphere that vanishes computes with denormals
  set(ForceId::ShapeMemory, 0, 0.2f);
  if (load == Load::Gradient || load == Load::AnyGradient || load == Load::FullGradient) {
    set(ForceId::Gradient, 0, 0.5f);
    set(ForceId::Gradient, GradientForce::samples, load == Load::FullGradient ? 10 : 6);  // 13 or 21 samples
    set(ForceId::Gradient, GradientForce::object, 1);
  }
  if (load == Load::FullProfile) {
    set(ForceId::IntensityProfile, 0, 0.5f);
    set(ForceId::IntensityProfile, IntensityProfileForce::half_length, 4);
    set(ForceId::IntensityProfile, IntensityProfileForce::samples, 6);  // 21 samples, 13 shifts
  }
  if (load == Load::FullGradient || load == Load::FullProfile) set(ForceId::Attraction, 0, 2);
  if (load == Load::Region) {
    set(ForceId::Evidence, 0, 0.5f);
    set(ForceId::Evidence, EvidenceForce::source, 1);
  }
  if (load == Load::Field) set(ForceId::Evidence, 0, 0.5f);
  if (load == Load::AnyGradient) set(ForceId::Gradient, GradientForce::object, 0);
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

/// Mesh with its references.
struct Item {
  SimplexMesh mesh;
  std::vector<Vec4> shape;
  std::vector<float> profiles;
  RegionModel region;
  bool asleep = false;  ///< the vertices are not counted
};
Item make_item(SimplexMesh mesh, Load load) {
  Item item;
  item.mesh = std::move(mesh);
  item.shape = shape_reference_of(item.mesh);
  item.region = estimate_region(phantom(), item.mesh, 20);
  if (load == Load::FullProfile) {
    const double step = 0.5 * phantom().geometry().spacing_mm.minCoeff();
    for (int i = 0; i < item.mesh.vertex_count(); ++i) {
      const Eigen::Vector3d normal = vertex_geometry(item.mesh, i).normal;
      for (int k = -4; k <= 4; ++k)
        item.profiles.push_back(
            static_cast<float>(phantom().sample(item.mesh.positions[i].cast<double>() + k * step * normal)));
    }
  }
  return item;
}

std::vector<EnginePoint> points_around(const Eigen::Vector3d& centre_mm, double radius_mm, int count, int mesh) {
  std::vector<EnginePoint> points;
  for (int k = 0; k < count; ++k) {  // a spiral from pole to pole
    const double z = 1 - 2 * (k + 0.5) / count, turn = 2.4 * k, r = std::sqrt(1 - z * z);
    points.push_back({mesh, centre_mm + radius_mm * Eigen::Vector3d(r * std::cos(turn), r * std::sin(turn), z)});
  }
  return points;
}

/// Number of steps rounded up to a multiple of the refresh interval, so that all batches have equally many refreshes.
int whole_cycles(int steps, int refresh_interval) {
  return std::max(1, (steps + refresh_interval - 1) / refresh_interval) * refresh_interval;
}

/// Measures the time of steps; `threads` = 0: CUDA.
void measure(benchmark::State& state, const std::vector<Item>& items, Load load, int refresh_interval, int threads,
             const std::vector<EnginePoint>& points, VolumeSampling sampling = VolumeSampling::Filtered) {
  std::vector<EngineMesh> meshes;
  std::size_t vertices = 0;
  for (const Item& item : items) {
    EngineMesh m;
    m.positions = m.previous = item.mesh.positions;
    m.neighbours = item.mesh.neighbours, m.shape = item.shape, m.profiles = item.profiles,
    m.parameters = forces_for(load);
    if (load == Load::Region) m.region = &item.region;
    m.asleep = item.asleep;
    meshes.push_back(m);
    if (!item.asleep) vertices += item.mesh.positions.size();
  }
  SimulationParameters simulation = default_simulation_parameters();
  simulation.solver_choice = static_cast<float>(Solver::Verlet);  // plain steps: no measurements for a solver, no cycle
  simulation.refresh_interval = static_cast<float>(refresh_interval);
  const auto engine = threads == 0 ? make_cuda_engine(sampling) : make_cpu_engine(threads);
  engine->set_volume(phantom());
  engine->load(meshes, simulation);
  if (load == Load::Field) {  // P falls from 1 to 0 over four voxels about the sphere's surface
    const VolumeGeometry& g = phantom().geometry();
    std::vector<std::uint16_t> field(g.voxel_count());
    for (std::size_t v = 0; v < field.size(); ++v) {
      const Eigen::Vector3d index(static_cast<double>(v % g.size[0]), static_cast<double>(v / g.size[0] % g.size[1]),
                                  static_cast<double>(v / g.size[0] / g.size[1]));
      const double depth = 35 - (g.world_from_index() * index - g.centre_mm()).norm();
      field[v] = static_cast<std::uint16_t>(65535 * std::clamp(0.5 + depth / 4, 0.0, 1.0));
    }
    for (std::size_t k = 0; k < meshes.size(); ++k)
      engine->set_field(static_cast<int>(k), {kVoxelCells, {{0, 0, 0}, g.size}, field});
  }
  engine->set_points(points);
  // Long batches make the time of launching and waiting negligible; a device needs longer ones.
  const int steps = threads == 0 ? static_cast<int>(std::clamp<std::size_t>(30'000'000 / vertices / 30 * 30, 30, 3000))
                                 : whole_cycles(static_cast<int>(200'000 / vertices), refresh_interval);
  for (int warm = 0; warm < 3; ++warm) engine->step(steps);
  for (auto _ : state)
    if (engine->step(steps).failure) state.SkipWithError("a step failed");
  const double vertex_steps = static_cast<double>(state.iterations()) * steps * static_cast<double>(vertices);
  state.counters["vertices"] = static_cast<double>(vertices);
  state.counters["ns_per_vertex"] =
      benchmark::Counter(vertex_steps * 1e-9, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
  state.counters["us_per_step"] = benchmark::Counter(static_cast<double>(state.iterations()) * steps * 1e-6,
                                                     benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

bool skipped(benchmark::State& state, int threads) {
  if (threads != 0 || cuda_unavailable_reason().empty()) return false;
  state.SkipWithError("no CUDA device");
  return true;
}

const Eigen::Vector3d& centre() {
  static const Eigen::Vector3d centre = phantom().geometry().centre_mm();
  return centre;
}

/// Arguments: vertices (rounded up to a sphere), threads.
void step(benchmark::State& state, Load load, int refresh_interval) {
  const int threads = static_cast<int>(state.range(1));
  if (skipped(state, threads)) return;
  std::vector<Item> items;
  items.push_back(make_item(make_sphere(centre(), 35, sphere_level_for(static_cast<int>(state.range(0)))), load));
  measure(state, items, load, refresh_interval, threads, {});
}

/// Arguments: vertices, vertices of an additional sleeping mesh. `threads`: 0 on a device.
void beside_sleeping(benchmark::State& state, Load load, int refresh_interval, int threads) {
  if (skipped(state, threads)) return;
  std::vector<Item> items;
  items.push_back(make_item(make_sphere(centre(), 35, sphere_level_for(static_cast<int>(state.range(0)))), load));
  if (state.range(1) > 0) {
    items.push_back(make_item(make_sphere(centre(), 30, sphere_level_for(static_cast<int>(state.range(1)))), load));
    items.back().asleep = true;
  }
  measure(state, items, load, refresh_interval, threads, {});
}

/// Argument: vertices = 20 f^2. Twenty attraction points if the load includes attraction.
void device(benchmark::State& state, Load load, int refresh_interval, VolumeSampling sampling) {
  if (skipped(state, 0)) return;
  const int f = static_cast<int>(std::lround(std::sqrt(static_cast<double>(state.range(0)) / 20)));
  static std::map<std::pair<int, bool>, Item> made;
  const std::pair key(f, load == Load::FullProfile);
  if (!made.contains(key)) made[key] = make_item(geodesic_sphere(centre(), 35, f), load);
  const std::vector<Item> items{made[key]};
  const bool attract = load == Load::FullGradient || load == Load::FullProfile;
  measure(state, items, load, refresh_interval, 0,
          attract ? points_around(centre(), 36, 20, 0) : std::vector<EnginePoint>{}, sampling);
}

/// Argument: number of meshes, with 200k vertices in total and equal edge lengths; two attraction points per 20k.
void meshes(benchmark::State& state, Load load) {
  if (skipped(state, 0)) return;
  const int count = static_cast<int>(state.range(0));
  const int f = count == 1 ? 101 : 32;
  std::vector<Item> items;
  std::vector<EnginePoint> points;
  for (int k = 0; k < count; ++k) {
    const double radius = 35 / std::sqrt(static_cast<double>(count));
    const Eigen::Vector3d at =
        centre() + (count == 1 ? Eigen::Vector3d(0, 0, 0)
                               : Eigen::Vector3d(20.0 * (k % 3) - 20, 20.0 * (k / 3 % 3) - 20, 20.0 * (k / 9)));
    items.push_back(make_item(geodesic_sphere(at, radius, f), load));
    const auto own = points_around(at, radius + 1, 20 / count, k);
    points.insert(points.end(), own.begin(), own.end());
  }
  measure(state, items, load, 1, 0, load == Load::Internal ? std::vector<EnginePoint>{} : points);
}

void sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"vertices", "threads"})->UseRealTime()->Unit(benchmark::kMillisecond);
  for (int threads : {1, 2})
    for (int vertices : {20, 320, 1280, 20480, 81920, 327680, 1310720}) b->Args({vertices, threads});
}
void with_and_without(benchmark::internal::Benchmark* b) {
  b->ArgNames({"vertices", "sleeping"})->UseRealTime()->Unit(benchmark::kMillisecond);
  for (int vertices : {320, 20480})
    for (int sleeping : {0, 81920}) b->Args({vertices, sleeping});
}
void device_sizes(benchmark::internal::Benchmark* b) {
  b->ArgNames({"vertices"})->UseRealTime()->Unit(benchmark::kMillisecond);
  for (int f : {10, 32, 64, 128, 224, 448}) b->Args({20 * f * f});
}

constexpr auto kFiltered = VolumeSampling::Filtered;
BENCHMARK_CAPTURE(step, internal, Load::Internal, 1)->Apply(sizes);
BENCHMARK_CAPTURE(step, gradient_13_samples_every_step, Load::Gradient, 1)->Apply(sizes);
BENCHMARK_CAPTURE(step, any_gradient_13_samples_every_step, Load::AnyGradient, 1)->Apply(sizes);
BENCHMARK_CAPTURE(step, region_every_third_step, Load::Region, 3)->Apply(sizes);
BENCHMARK_CAPTURE(step, field_every_third_step, Load::Field, 3)->Apply(sizes);
BENCHMARK_CAPTURE(beside_sleeping, internal, Load::Internal, 1, 1)->Apply(with_and_without);
BENCHMARK_CAPTURE(beside_sleeping, gradient_13_samples_every_step, Load::Gradient, 1, 1)->Apply(with_and_without);
BENCHMARK_CAPTURE(beside_sleeping, device_internal, Load::Internal, 1, 0)->Apply(with_and_without);
BENCHMARK_CAPTURE(beside_sleeping, device_gradient_13_samples_every_step, Load::Gradient, 1, 0)
    ->Apply(with_and_without);
BENCHMARK_CAPTURE(device, internal, Load::Internal, 1, kFiltered)->Apply(device_sizes);
BENCHMARK_CAPTURE(device, full_gradient, Load::FullGradient, 1, kFiltered)->Apply(device_sizes);
BENCHMARK_CAPTURE(device, full_profile, Load::FullProfile, 1, kFiltered)->Apply(device_sizes);
BENCHMARK_CAPTURE(device, full_gradient_every_third_step, Load::FullGradient, 3, kFiltered)->Apply(device_sizes);
BENCHMARK_CAPTURE(device, region_every_third_step, Load::Region, 3, kFiltered)->Apply(device_sizes);
BENCHMARK_CAPTURE(device, full_gradient_fetched, Load::FullGradient, 1, VolumeSampling::Fetched)->Apply(device_sizes);
BENCHMARK_CAPTURE(device, full_gradient_linear, Load::FullGradient, 1, VolumeSampling::Linear)->Apply(device_sizes);
BENCHMARK_CAPTURE(meshes, internal, Load::Internal)
    ->ArgName("meshes")
    ->Arg(1)
    ->Arg(10)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(meshes, full_gradient, Load::FullGradient)
    ->ArgName("meshes")
    ->Arg(1)
    ->Arg(10)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(meshes, full_profile, Load::FullProfile)
    ->ArgName("meshes")
    ->Arg(1)
    ->Arg(10)
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace simplexseg

BENCHMARK_MAIN();
