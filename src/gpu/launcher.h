// SPDX-License-Identifier: Apache-2.0
// An executor defines types of arrays in its memory and runs kernels. Main members:
// - Array<T>: data(), size(), resize(n) (contents undefined afterwards), assign(span) (resizes and uploads),
//   assign_async(span) (the source must not change until wait()), upload(span), download(span), fill_zero(); for Vec4
//   also texels(), the read-only view of kernels
// - Shared<T>: array that kernels only read; share(span): makes the values readable, which must stay unchanged; data()
// - NeighbourArray: array of Int4 that kernels only read; assign(span), texels()
// - HostVisible<T>: array that kernels write and that the host reads after wait()
// - wait(): returns after all earlier runs and transfers
// - run(kernel, n): calls kernel(0) ... kernel(n - 1), after all earlier runs
// - run(kernel): calls kernel(block), for kernels that are executed by one thread block
// - run_concurrently(a, na, b, nb): runs both kernels, in any order or at the same time
// - run_over_vertices(kernel, n): run() over all vertices or, after restrict_vertices(ranges), over these ranges, the
//   first of which contains vertex 0, and possibly vertices near them. The restriction also applies to `a` of
//   run_concurrently() and to run_tiles(); it is removed by restrict_vertices({})
// - run_tiles(kernel): runs a TileStep; only if kTiles
// - record(body) -> Recording: records the runs of body() without executing them; only if kRecords
// - replay(recording): executes the recorded runs with little overhead; only if kRecords
// - kSumsRings: whether the kernel SumRings is used (gpu/kernels.h)
// - visit_width(n, f): calls f with the number of threads per search, as an integral_constant, for n searches
// - bind(volume, view): gives kernels access to the voxels through `view`
// - visit_voxels(type, f): calls f with the type_identity of the sampler for a type of voxels
#pragma once
#include <cstdint>
#include <map>
#include <string_view>

namespace simplexseg {

/// Range of vertices: first ... last - 1, counted over all meshes.
struct VertexRange {
  int first, last;
};

/// Runs kernels on an executor and counts the launches of each.
template <class Executor>
struct Launcher {
  Executor executor;
  std::map<std::string_view, std::uint64_t> launches{};  ///< number of launches by kernel name

  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    executor.run(kernel, n);
  }
  /// Runs a kernel over all vertices; those of sleeping meshes (MeshConstants::asleep) may be skipped.
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    executor.run_over_vertices(kernel, n);
  }
  /// Runs a kernel that is executed by one thread block.
  template <class Kernel>
  void run(const Kernel& kernel) {
    ++launches[Kernel::name];
    executor.run(kernel);
  }
  /// Runs a step in tiles: one launch that fuses two kernels and is counted for both.
  template <class Kernel>
  void run_tiles(const Kernel& kernel) {
    ++launches[Kernel::name], ++launches[Kernel::fused_name];
    executor.run_tiles(kernel);
  }
  /// Runs two independent kernels, in any order or at the same time: `a` as run_over_vertices(a, na), `b` as run(b,
  /// nb).
  template <class A, class B>
  void run_concurrently(const A& a, int na, const B& b, int nb) {
    ++launches[A::name], ++launches[B::name];
    executor.run_concurrently(a, na, b, nb);
  }
};

}  // namespace simplexseg
