// SPDX-License-Identifier: Apache-2.0
#include "evidence/geodesic_distance.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/vec3.h"

namespace simplexseg {
namespace {

/// Raster scans of rows. A Rule says what a row takes from another row, scanned before, and along itself.
template <class Rule>
void scan(std::span<float> values, const BoxGrid& grid, int rounds, const Rule& rule) {
  const auto [ni, nj, nk] = grid.size;
  std::vector<float> before(ni);
  bool changed = true;
  for (int round = 0; round < rounds && changed; ++round) {
    changed = false;
    for (const int way : {1, -1}) {
      for (int kk = 0; kk < nk; ++kk) {
        for (int jj = 0; jj < nj; ++jj) {
          const int k = way > 0 ? kk : nk - 1 - kk, j = way > 0 ? jj : nj - 1 - jj;
          const std::size_t row = (std::size_t(k) * nj + j) * ni;
          float* const to = values.data() + row;
          std::copy_n(to, ni, before.data());
          const auto take = [&, ni = ni, nj = nj, nk = nk](int dj, int dk) {
            if (j + dj < 0 || j + dj >= nj || k + dk < 0 || k + dk >= nk) return;
            rule.from_row(row, (std::size_t(k + dk) * nj + j + dj) * ni, ni, dj, dk);
          };
          take(-way, 0);
          take(-1, -way);
          take(0, -way);
          take(1, -way);
          rule.along(row, ni, way);
          for (int i = 0; i < ni; ++i) changed |= std::fabs(to[i] - before[i]) > 1e-6f;
        }
      }
    }
  }
}

/// Takes offer(i, i + o) at i - 1, i and i + 1 of another row, the better of two being pick(a, b).
template <class Offer, class Pick>
void take_from_row(float* to, int n, const Offer& offer, const Pick& pick) {
  to[0] = pick(offer(0, 0), to[0]);
  if (n > 1) to[0] = pick(offer(0, 1), to[0]);
#pragma GCC ivdep
  for (int i = 1; i < n - 1; ++i) to[i] = pick(pick(offer(i, 0), pick(offer(i, -1), offer(i, 1))), to[i]);
  if (n > 1) to[n - 1] = pick(pick(offer(n - 1, 0), offer(n - 1, -1)), to[n - 1]);
}

template <bool kEdges>
struct Geodesic {
  float* distance;
  const float* image;
  float length, edge2;
  std::array<double, 3> spacing;  ///< in units of the least

  float step(float difference) const { return cost_of_difference<kEdges>(difference, edge2); }
  float way(double a, double b, double c) const {
    return length * static_cast<float>(std::sqrt(a * a + b * b + c * c));
  }
  void from_row(std::size_t row, std::size_t other, int n, int dj, int dk) const {
    const float straight = way(0, dj * spacing[1], dk * spacing[2]),
                slant = way(spacing[0], dj * spacing[1], dk * spacing[2]);
    const float *const from = distance + other, *const there = image + other, *const here = image + row;
    take_from_row(
        distance + row, n,
        [=, this](int i, int o) { return from[i + o] + step(here[i] - there[i + o]) + (o == 0 ? straight : slant); },
        [](float a, float b) { return smaller(a, b); });
  }
  void along(std::size_t row, int n, int way_on) const {
    float* const d = distance + row;
    const float* const here = image + row;
    const float on = way(spacing[0], 0, 0);
    if (way_on > 0)
      for (int i = 1; i < n; ++i) d[i] = smaller(d[i - 1] + step(here[i] - here[i - 1]) + on, d[i]);
    else
      for (int i = n - 2; i >= 0; --i) d[i] = smaller(d[i + 1] + step(here[i] - here[i + 1]) + on, d[i]);
  }
};

}  // namespace

void lower_geodesic_distance(std::span<float> distance, std::span<const float> image, const BoxGrid& grid,
                             const std::array<double, 3>& spacing_mm, const EdgeCost& cost, int rounds) {
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  const std::array<double, 3> spacing{spacing_mm[0] / least, spacing_mm[1] / least, spacing_mm[2] / least};
  if (cost.edge > 0)
    scan(distance, grid, rounds,
         Geodesic<true>{distance.data(), image.data(), cost.length, cost.edge * cost.edge, spacing});
  else
    scan(distance, grid, rounds, Geodesic<false>{distance.data(), image.data(), cost.length, 0, spacing});
}

}  // namespace simplexseg
