// SPDX-License-Identifier: Apache-2.0
// Sections of a layer on the grid of slices, as the window computes them when a slice changes: two volumes of
// 512x512x600 voxels (int16), the layer turned and shifted, or displaced by a field.
#include <benchmark/benchmark.h>

#include <thread>

#include "core/thread_pool.h"
#include "image/plane_samples.h"

namespace simplexseg {
namespace {

const Volume& large_volume() {
  static const Volume volume = [] {
    VolumeGeometry geometry;
    geometry.size = {512, 512, 600};
    geometry.spacing_mm = {0.8, 0.8, 1};
    Volume made(geometry, VoxelType::Int16);
    std::uint32_t state = 1;
    for (std::int16_t& voxel : made.voxels<std::int16_t>())
      voxel = static_cast<std::int16_t>((state = state * 1664525u + 1013904223u) >> 20);
    return made;
  }();
  return volume;
}

Transform turned() {
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  affine.linear() = Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  affine.translation() = Eigen::Vector3d(5, -7, 11);
  return Transform(affine);
}

Transform displaced() {
  VolumeGeometry grid;
  grid.size = {100, 100, 100}, grid.spacing_mm = {4.1, 4.1, 6};
  Transform transform;
  transform.append(DisplacementField(grid, std::vector<Eigen::Vector3f>(1'000'000, Eigen::Vector3f(1, 2, 3))));
  transform.append(turned());
  return transform;
}

/// `axis`: normal of the slices, 0 sagittal, 1 coronal, 2 axial. The slice moves with each iteration.
void sample_slices(benchmark::State& state, const Transform& transform) {
  const Volume& volume = large_volume();
  const int axis = static_cast<int>(state.range(0)), u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  ThreadPool pool(std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
  PlaneGrid grid;
  grid.step_u_mm = Eigen::Vector3d::Unit(u) * volume.geometry().spacing_mm[u];
  grid.step_v_mm = Eigen::Vector3d::Unit(v) * volume.geometry().spacing_mm[v];
  grid.width = volume.geometry().size[static_cast<std::size_t>(u)];
  grid.height = volume.geometry().size[static_cast<std::size_t>(v)];
  std::vector<PlaneSample> samples(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
  int slice = 100;
  for (auto _ : state) {
    grid.origin_mm[axis] = volume.geometry().spacing_mm[axis] * (100 + slice++ % 300);
    sample_plane(volume, transform, grid, samples, pool);
    benchmark::DoNotOptimize(samples.data());
  }
}

void LayerSlicesAffine(benchmark::State& state) { sample_slices(state, turned()); }
void LayerSlicesField(benchmark::State& state) { sample_slices(state, displaced()); }
BENCHMARK(LayerSlicesAffine)->DenseRange(0, 2)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK(LayerSlicesField)->DenseRange(0, 2)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace simplexseg

BENCHMARK_MAIN();
