// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Vertices per patch; the fastest value between 64 and 512.
inline constexpr int kPatchVertices = 256;

/// Order of the vertices of a mesh by patches. Each patch grows breadth-first from the vertex that has been adjacent to
/// earlier patches for longest. A step reads two rings around a vertex: these lie mostly in the same patch, and
/// adjacent patches lie near each other in memory. The order in which refinement creates vertices scatters the reads
/// (figures: docs/adr/0009-vertex-order.md).
inline std::vector<int> patch_order(std::span<const std::array<int, 3>> neighbours) {
  const int n = static_cast<int>(neighbours.size());
  std::vector<int> order, queue;  // queue: in order of discovery; some vertices may already be in a patch
  order.reserve(n), queue.reserve(n);
  enum : char { kUnseen, kQueued, kAssigned };
  std::vector<char> state(n, kUnseen);
  std::size_t head = 0;
  for (int start = 0; static_cast<int>(order.size()) < n;) {
    // A patch fills one block. A region enclosed by other patches may be smaller; a second seed then fills the block.
    int seed = -1;
    while (head < queue.size() && seed < 0)
      if (const int candidate = queue[head++]; state[candidate] != kAssigned) seed = candidate;
    while (seed < 0) {
      if (state[start] != kAssigned) seed = start;
      ++start;
    }
    std::size_t next = order.size();
    order.push_back(seed);
    state[seed] = kAssigned;
    const std::size_t end = (next / kPatchVertices + 1) * kPatchVertices;
    for (; next < order.size(); ++next)
      for (int j : neighbours[order[next]]) {
        if (state[j] == kAssigned) continue;
        if (order.size() < end) {
          state[j] = kAssigned;
          order.push_back(j);
        } else if (state[j] == kUnseen) {
          state[j] = kQueued;
          queue.push_back(j);
        }
      }
  }
  return order;
}

}  // namespace simplexseg
