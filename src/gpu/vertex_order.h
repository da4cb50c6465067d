// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Vertices of a patch: of 64 to 512, what was fastest.
inline constexpr int kPatchVertices = 256;

/// The vertices of a mesh patch by patch: a patch grows breadth-first from the vertex that has waited longest beside
/// the patches before it. Two rings around a vertex, which a step reads, then mostly lie in the patch itself, and
/// patches that touch lie near each other. A refined sphere has its vertices in the order of their birth, which
/// scatters every gather (figures: docs/adr/0009-vertex-order.md).
inline std::vector<int> patch_order(std::span<const std::array<int, 3>> neighbours) {
  const int n = static_cast<int>(neighbours.size());
  std::vector<int> order, waiting;  // waiting: in the order of being met; some are taken meanwhile
  order.reserve(n), waiting.reserve(n);
  enum : char { kFar, kWaiting, kTaken };
  std::vector<char> state(n, kFar);
  std::size_t head = 0;
  for (int start = 0; static_cast<int>(order.size()) < n;) {
    // A patch fills one block; what is enclosed by others may be too small for that, and another is begun.
    int seed = -1;
    while (head < waiting.size() && seed < 0)
      if (const int candidate = waiting[head++]; state[candidate] != kTaken) seed = candidate;
    while (seed < 0) {
      if (state[start] != kTaken) seed = start;
      ++start;
    }
    std::size_t next = order.size();
    order.push_back(seed);
    state[seed] = kTaken;
    const std::size_t end = (next / kPatchVertices + 1) * kPatchVertices;
    for (; next < order.size(); ++next)
      for (int j : neighbours[order[next]]) {
        if (state[j] == kTaken) continue;
        if (order.size() < end) {
          state[j] = kTaken;
          order.push_back(j);
        } else if (state[j] == kFar) {
          state[j] = kWaiting;
          waiting.push_back(j);
        }
      }
  }
  return order;
}

}  // namespace simplexseg
