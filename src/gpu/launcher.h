// SPDX-License-Identifier: Apache-2.0
// An executor owns memory and runs kernels:
// - Array<T>: data(), size(), resize(n) (contents lost), upload(span), download(span), fill_zero(); texels() of Vec4;
//   assign_async(span): resizes and uploads; the caller leaves the source unchanged until wait()
// - NeighbourArray: Array of Int4, written once; texels()
// - HostVisible<T>: memory that kernels write and that the host reads after wait()
// - run(kernel, n): kernel(0) ... kernel(n-1), after all earlier runs
// - run(kernel): kernel(block), for kernels that a whole block of threads executes
// - run_concurrently(a, na, b, nb): both kernels, in any order
// - run_over_vertices(kernel, n): run() over all vertices, or only over the ranges set by restrict_vertices(ranges),
//   the first of which contains vertex 0. The restriction also applies to `a` of run_concurrently() and to run_tiles()
// - run_tiles(kernel): a TileStep; only if kTiles
// - record(body) -> Recording, replay(recording): repeat a recorded run at small cost; only if kRecords
// - kSumsRings: SumRings is run and its sums are stored
// - visit_width(n, f): f(number of lanes that share one of n searches)
// - bind(volume, view): makes the voxels readable; visit_voxels(type, f): f(type identity of their sampler)
#pragma once
#include <cstdint>
#include <map>
#include <string_view>

namespace simplexseg {

/// Vertices first ... last - 1.
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
  /// Runs a kernel over all vertices except those of settled meshes (MeshConstants::idle).
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    executor.run_over_vertices(kernel, n);
  }
  /// Runs a kernel that one block of threads executes.
  template <class Kernel>
  void run(const Kernel& kernel) {
    ++launches[Kernel::name];
    executor.run(kernel);
  }
  /// Runs a step of all vertices by tiles; one launch does the work of two kernels.
  template <class Kernel>
  void run_tiles(const Kernel& kernel) {
    ++launches[Kernel::name], ++launches[Kernel::fused_name];
    executor.run_tiles(kernel);
  }
  /// Runs two independent kernels; `a` runs over vertices.
  template <class A, class B>
  void run_concurrently(const A& a, int na, const B& b, int nb) {
    ++launches[A::name], ++launches[B::name];
    executor.run_concurrently(a, na, b, nb);
  }
};

}  // namespace simplexseg
