// SPDX-License-Identifier: Apache-2.0
// Loops of the CPU over indices. Work is divided into blocks that do not depend on the number of threads, so that every
// number of threads gives the same bits.
#pragma once
#include <algorithm>
#include <cstddef>
#include <functional>

namespace simplexseg {

/// Runs job(0) ... job(jobs - 1), in any order and on any threads, and returns when all have returned.
using RunJobs = std::function<void(int jobs, const std::function<void(int)>& job)>;

/// Runs jobs in ascending order on the thread of the caller.
inline RunJobs run_serially() {
  return [](int jobs, const std::function<void(int)>& job) {
    for (int j = 0; j < jobs; ++j) job(j);
  };
}

constexpr int kIndicesPerJob = 16384;

/// Calls kernel(v) for all 0 <= v < n; no call may read a value that another one writes.
template <class Kernel>
void for_each_index(const RunJobs& run, int n, const Kernel& kernel) {
  run((n + kIndicesPerJob - 1) / kIndicesPerJob, [&](int block) {
    const Kernel k = kernel;
    const int last = std::min(n, (block + 1) * kIndicesPerJob);
#pragma GCC ivdep
    for (int v = block * kIndicesPerJob; v < last; ++v) k(v);
  });
}

}  // namespace simplexseg
