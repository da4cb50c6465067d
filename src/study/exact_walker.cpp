// SPDX-License-Identifier: Apache-2.0
#include "study/exact_walker.h"

namespace simplexseg {

std::vector<double> exact_walker_solution(const WalkerSystem& system) {
  const BoxGrid& grid = system.grid;
  const int n = grid.count();
  std::vector<double> x(system.start.begin(), system.start.end());
  std::vector<int> row(n, -1), cells;
  for (int v = 0; v < n; ++v)
    if (system.fixed[v] == 0) row[v] = static_cast<int>(cells.size()), cells.push_back(v);
  const int count = static_cast<int>(cells.size());
  // Conductances between free cells, and from each to the two terminals x = 0 and x = 1.
  std::vector<double> g(static_cast<std::size_t>(count) * count), to_0(count), to_1(count);
  const auto at = [&](int a, int b) -> double& { return g[static_cast<std::size_t>(a) * count + b]; };
  const auto connect = [&](int free, double conductance, double value) {
    to_0[free] += conductance * (1 - value), to_1[free] += conductance * value;
  };
  for (int v = 0; v < n; ++v) {
    if (row[v] >= 0) connect(row[v], system.prior_weight[v], system.prior[v] / 255.0);
    for (int axis = 0; axis < 3; ++axis) {
      const double w = system.conductance[axis][v];
      if (!(w > 0)) continue;
      const int u = v + grid.stride(axis);
      if (row[v] >= 0 && row[u] >= 0)
        at(row[v], row[u]) += w, at(row[u], row[v]) += w;
      else if (row[v] >= 0)
        connect(row[v], w, x[u]);
      else if (row[u] >= 0)
        connect(row[u], w, x[v]);
    }
  }
  // Elimination of cell e distributes its conductances over pairs of its neighbours (star-mesh transform).
  std::vector<double> sums(count);
  for (int e = count - 1; e >= 0; --e) {
    double sum = to_0[e] + to_1[e];
    for (int a = 0; a < e; ++a) sum += at(e, a);
    sums[e] = sum;
    if (!(sum > 0)) continue;
    for (int a = 0; a < e; ++a) {
      const double share = at(e, a) / sum;
      if (!(share > 0)) continue;
      for (int b = 0; b < e; ++b)
        if (b != a) at(a, b) += share * at(e, b);
      to_0[a] += share * to_0[e], to_1[a] += share * to_1[e];
    }
  }
  for (int e = 0; e < count; ++e) {
    if (!(sums[e] > 0)) continue;
    double value = to_1[e];
    for (int a = 0; a < e; ++a) value += at(e, a) * x[cells[a]];
    x[cells[e]] = value / sums[e];
  }
  return x;
}

}  // namespace simplexseg
