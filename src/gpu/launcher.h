// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>

namespace simplexseg {

/// Vertices first ... last - 1.
struct VertexRange {
  int first, last;
};

/// Runs kernels on an executor, and counts how often each was.
template <class Executor>
struct Launcher {
  Executor executor;
  std::map<std::string, std::uint64_t> launches{};

  template <class Kernel>
  void run(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    executor.run(kernel, n);
  }
  /// Over vertices, those that rest left out where the executor can (MeshConstants::rests).
  template <class Kernel>
  void run_over_vertices(const Kernel& kernel, int n) {
    ++launches[Kernel::name];
    if constexpr (Executor::kLeavesOut)
      executor.run_over_vertices(kernel, n);
    else
      executor.run(kernel, n);
  }
  /// One that is written for a team.
  template <class Kernel>
  void run(const Kernel& kernel) {
    ++launches[Kernel::name];
    executor.run(kernel);
  }
  /// `a` is over vertices.
  template <class A, class B>
  void run_together(const A& a, int na, const B& b, int nb) {
    ++launches[A::name], ++launches[B::name];
    executor.run_together(a, na, b, nb);
  }
};

}  // namespace simplexseg
