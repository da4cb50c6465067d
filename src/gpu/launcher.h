// SPDX-License-Identifier: Apache-2.0
// An executor owns memory and runs kernels:
// - Array<T>: data(), size(), resize(n) (contents lost), upload(span), download(span), fill_zero(); texels() of Vec4;
//   assign_kept(span): resized and filled, by memory that stays as it is until wait()
// - NeighbourArray: the same for Int4, written once; texels()
// - HostVisible<T>: memory that kernels write and, after wait(), the host reads
// - run(kernel, n): kernel(0) ... kernel(n-1), ordered after all earlier runs
// - run_together(a, na, b, nb): both, in any order; run(kernel): kernel(team), where it is written for one
// - record(body) -> Recording, replay(recording): where kRecords, runs that are kept and repeated at small cost
// - run_over_vertices(kernel, n): the same over all vertices; those outside of the ranges of leave_to(ranges), which
//   begin with the first vertex, may be left out, here, in run_together(a, ...) and in run_tiles(kernel): a TileStep,
//   where kTiles
// - kSumsRings: SumRings is run, and its sums are held
// - visit_width(n, f): f(how many lanes work on a search when there are n of them)
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

/// Runs kernels on an executor, and counts how often each was.
template <class Executor>
struct Launcher {
  Executor executor;
  std::map<std::string_view, std::uint64_t> launches{};  ///< of each kernel, by its name

  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    executor.run(kernel, n);
  }
  /// Over vertices, those that rest left out (MeshConstants::rests).
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    executor.run_over_vertices(kernel, n);
  }
  /// One that is written for a team.
  template <class Kernel>
  void run(const Kernel& kernel) {
    ++launches[Kernel::name];
    executor.run(kernel);
  }
  /// A step of all vertices by tiles: the launch does the work of two kernels.
  template <class Kernel>
  void run_tiles(const Kernel& kernel) {
    ++launches[Kernel::name], ++launches[Kernel::with];
    executor.run_tiles(kernel);
  }
  /// `a` is over vertices.
  template <class A, class B>
  void run_together(const A& a, int na, const B& b, int nb) {
    ++launches[A::name], ++launches[B::name];
    executor.run_together(a, na, b, nb);
  }
};

}  // namespace simplexseg
