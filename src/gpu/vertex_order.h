// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Number of vertices per patch; the fastest value measured between 64 and 512.
inline constexpr int kPatchVertices = 256;

/// Patch order of the vertices of a mesh: the index of the vertex at each position. Each patch grows breadth-first from
/// the first vertex that was found adjacent to an earlier patch. A step reads two rings around a vertex: they lie
/// mostly in the same patch, and adjacent patches are near each other in memory. In the order in which refinement
/// creates vertices, these reads would be scattered (figures: docs/adr/0009-vertex-order.md).
inline std::vector<int> patch_order(std::span<const std::array<int, 3>> neighbours) {
  const int n = static_cast<int>(neighbours.size());
  std::vector<int> order, queue;  // queue: seeds in order of discovery; some may be in a patch already
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
