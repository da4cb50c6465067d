// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <map>
#include <string>

namespace simplexseg {

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
  /// One that is written for a team.
  template <class Kernel>
  void run(const Kernel& kernel) {
    ++launches[Kernel::name];
    executor.run(kernel);
  }
  template <class A, class B>
  void run_together(const A& a, int na, const B& b, int nb) {
    ++launches[A::name], ++launches[B::name];
    executor.run_together(a, na, b, nb);
  }
};

}  // namespace simplexseg
