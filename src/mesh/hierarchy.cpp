// SPDX-License-Identifier: Apache-2.0
#include "mesh/hierarchy.h"

#include <algorithm>

#include "core/expect.h"

namespace simplexseg {
namespace {

using Edge = Hierarchy::Edge;
using Level = Hierarchy::Level;

/// Graph whose edges are stored as compressed rows.
struct Graph {
  std::vector<int> first{0};
  std::vector<Edge> edges;
  int size() const { return static_cast<int>(first.size()) - 1; }
  std::span<const Edge> of(int i) const {
    return {edges.data() + first[i], static_cast<std::size_t>(first[i + 1] - first[i])};
  }
};

/// Assigns each vertex to a coarse vertex (aggregate); returns the number of aggregates. In breadth-first order, a
/// vertex forms an aggregate with its neighbours if none of these vertices is assigned yet. Each remaining vertex joins
/// the smallest adjacent aggregate.
int aggregate(const Graph& graph, std::vector<int>& coarse_of) {
  const int n = graph.size();
  coarse_of.assign(n, -1);
  std::vector<char> visited(n, 0);
  std::vector<int> queue, sizes;
  for (int start = 0; start < n; ++start) {
    if (visited[start]) continue;
    queue.assign(1, start);
    visited[start] = 1;
    for (std::size_t head = 0; head < queue.size(); ++head) {
      const int i = queue[head];
      bool free = coarse_of[i] < 0;
      for (const Edge& e : graph.of(i)) {
        free = free && coarse_of[e.to] < 0;
        if (!visited[e.to]) visited[e.to] = 1, queue.push_back(e.to);
      }
      if (!free) continue;
      const int c = static_cast<int>(sizes.size());
      coarse_of[i] = c;
      for (const Edge& e : graph.of(i)) coarse_of[e.to] = c;
      sizes.push_back(1 + static_cast<int>(graph.of(i).size()));
    }
  }
  const std::vector<int> assigned = coarse_of;
  for (int i = 0; i < n; ++i) {
    if (assigned[i] >= 0) continue;
    int best = -1;
    for (const Edge& e : graph.of(i))
      if (const int c = assigned[e.to]; c >= 0 && (best < 0 || sizes[c] < sizes[best])) best = c;
    coarse_of[i] = best;  // never -1: a vertex without an assigned neighbour has formed an aggregate
    ++sizes[best];
  }
  return static_cast<int>(sizes.size());
}

/// Energy of a coarse displacement after rescaling, relative to the exact energy. Piecewise constant prolongation turns
/// a smooth displacement into jumps between aggregates, whose energy is too large by a factor: the number of vertices
/// per aggregate times the share of edges between aggregates (exact for a linear displacement). The rescaling leaves an
/// excess of 20%, so that the correction does not overshoot (docs/adr/0011-solvers.md).
constexpr double kRescaledEnergy = 1.2;

}  // namespace

Hierarchy make_hierarchy(std::span<const std::array<int, 3>> neighbours) {
  Hierarchy hierarchy;
  Graph graph;
  graph.first.reserve(neighbours.size() + 1), graph.edges.reserve(3 * neighbours.size());
  for (const auto& nb : neighbours) {
    for (int j : nb) graph.edges.push_back({j, 1.0f / 3.0f});
    graph.first.push_back(static_cast<int>(graph.edges.size()));
  }
  std::vector<int> coarse_of, slot;
  while (graph.size() > 1) {
    const int n = graph.size(), count = aggregate(graph, coarse_of);
    if (count == n) break;  // no edges are left
    Level level;
    level.part_first.assign(count + 1, 0);
    for (int c : coarse_of) ++level.part_first[c + 1];
    for (int c = 0; c < count; ++c) level.part_first[c + 1] += level.part_first[c];
    level.parts.resize(n);
    std::vector<int> at(level.part_first.begin(), level.part_first.end() - 1);
    for (int i = 0; i < n; ++i) level.parts[at[coarse_of[i]]++] = i;

    Graph coarse;
    double total = 0, cut = 0;
    slot.assign(count, -1);
    for (int c = 0; c < count; ++c) {
      const int begin = static_cast<int>(coarse.edges.size());
      for (int p = level.part_first[c]; p < level.part_first[c + 1]; ++p)
        for (const Edge& e : graph.of(level.parts[p])) {
          total += e.conductance;
          const int to = coarse_of[e.to];
          if (to == c) continue;
          cut += e.conductance;
          if (slot[to] < begin) slot[to] = static_cast<int>(coarse.edges.size()), coarse.edges.push_back({to, 0});
          coarse.edges[slot[to]].conductance += e.conductance;
        }
      coarse.first.push_back(static_cast<int>(coarse.edges.size()));
    }
    if (cut > 0) {
      const auto factor = static_cast<float>(std::min(1.0, kRescaledEnergy * total / (cut * n / count)));
      for (Edge& e : coarse.edges) e.conductance *= factor;
    }
    level.edge_first = coarse.first, level.edges = coarse.edges;
    SIMPLEXSEG_ENSURE(level.size() == count && static_cast<int>(level.edge_first.size()) == count + 1);
    hierarchy.levels.push_back(std::move(level));
    graph = std::move(coarse);
  }
  return hierarchy;
}

}  // namespace simplexseg
