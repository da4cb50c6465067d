// SPDX-License-Identifier: Apache-2.0
// How the evidence field runs its kernels. A kernel is a functor over the indices of an array: the loops here are the
// CPU's launch of it. Work is cut into blocks that do not depend on the number of threads, and sums are taken block by
// block in a fixed order, so that every number of threads gives the same bits.
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace simplexseg {

/// Runs job(0) ... job(jobs - 1), in any order and on any threads, and returns when all have returned.
using RunJobs = std::function<void(int jobs, const std::function<void(int)>& job)>;

/// One after the other, on the thread of the caller.
inline RunJobs run_in_turn() {
  return [](int jobs, const std::function<void(int)>& job) {
    for (int j = 0; j < jobs; ++j) job(j);
  };
}

constexpr int indices_a_block = 16384;

/// Calls kernel(v) for all 0 <= v < n; no call may read what another writes.
template <class Kernel>
void for_each_index(const RunJobs& run, int n, const Kernel& kernel) {
  run((n + indices_a_block - 1) / indices_a_block, [&](int block) {
    const Kernel k = kernel;
    const int last = std::min(n, (block + 1) * indices_a_block);
#pragma GCC ivdep
    for (int v = block * indices_a_block; v < last; ++v) k(v);
  });
}

/// The sum of kernel(v) over all 0 <= v < n, in double.
template <class Kernel>
double sum_over_indices(const RunJobs& run, int n, const Kernel& kernel) {
  const int blocks = (n + indices_a_block - 1) / indices_a_block;
  std::vector<double> sums(blocks);
  run(blocks, [&](int block) {
    const Kernel k = kernel;
    const int first = block * indices_a_block, last = std::min(n, first + indices_a_block);
    // Eight sums side by side, and a short run of each in float: exact enough, and the compiler vectorises it.
    double sum = 0;
    for (int start = first; start < last; start += 512) {
      const int stop = std::min(last, start + 512);
      std::array<float, 8> lane{};
      int v = start;
      for (; v + 8 <= stop; v += 8) {
#pragma GCC ivdep
        for (int l = 0; l < 8; ++l) lane[l] += k(v + l);
      }
      for (; v < stop; ++v) lane[0] += k(v);
      for (const float s : lane) sum += s;
    }
    sums[block] = sum;
  });
  double total = 0;
  for (const double s : sums) total += s;
  return total;
}

}  // namespace simplexseg
