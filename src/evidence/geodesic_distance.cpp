// SPDX-License-Identifier: Apache-2.0
#include "evidence/geodesic_distance.h"

#include <algorithm>
#include <cmath>

#include "core/vec3.h"

namespace simplexseg {
namespace {

/// One row of a raster scan takes what another, scanned before, offers at i - 1, i and i + 1.
void take_from_row(float* to, const float* image, const float* from, const float* from_image, int n, float straight,
                   float slant) {
  const auto offer = [&](int i, int o, float length) {
    return from[i + o] + std::fabs(image[i] - from_image[i + o]) + length;
  };
  to[0] = smaller(offer(0, 0, straight), to[0]);
  if (n > 1) to[0] = smaller(offer(0, 1, slant), to[0]);
#pragma GCC ivdep
  for (int i = 1; i < n - 1; ++i) {
    const float side = smaller(offer(i, -1, slant), offer(i, 1, slant));
    to[i] = smaller(smaller(offer(i, 0, straight), side), to[i]);
  }
  if (n > 1) {
    to[n - 1] = smaller(offer(n - 1, 0, straight), to[n - 1]);
    to[n - 1] = smaller(offer(n - 1, -1, slant), to[n - 1]);
  }
}

}  // namespace

void lower_geodesic_distance(std::span<float> distance, std::span<const float> image, const BoxGrid& grid,
                             const std::array<double, 3>& spacing_mm, float length_cost, int rounds) {
  const auto [ni, nj, nk] = grid.size;
  const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
  const double x = spacing_mm[0] / least, y = spacing_mm[1] / least, z = spacing_mm[2] / least;
  const auto cost = [&](double a, double b, double c) {
    return static_cast<float>(length_cost * std::sqrt(a * a + b * b + c * c));
  };
  const auto row = [&, ni = ni, nj = nj](int j, int k) { return (std::size_t(k) * nj + j) * ni; };
  std::vector<float> before(ni);
  bool changed = true;
  for (int round = 0; round < rounds && changed; ++round) {
    changed = false;
    for (const int way : {1, -1}) {
      for (int kk = 0; kk < nk; ++kk) {
        for (int jj = 0; jj < nj; ++jj) {
          const int k = way > 0 ? kk : nk - 1 - kk, j = way > 0 ? jj : nj - 1 - jj;
          float* const d = distance.data() + row(j, k);
          const float* const here = image.data() + row(j, k);
          std::copy_n(d, ni, before.data());
          const auto take = [&, ni = ni, nj = nj, nk = nk](int dj, int dk) {
            if (j + dj < 0 || j + dj >= nj || k + dk < 0 || k + dk >= nk) return;
            const std::size_t from = row(j + dj, k + dk);
            take_from_row(d, here, distance.data() + from, image.data() + from, ni, cost(0, dj * y, dk * z),
                          cost(x, dj * y, dk * z));
          };
          take(-way, 0);
          take(-1, -way);
          take(0, -way);
          take(1, -way);
          const float along = cost(x, 0, 0);
          if (way > 0)
            for (int i = 1; i < ni; ++i) d[i] = smaller(d[i - 1] + std::fabs(here[i] - here[i - 1]) + along, d[i]);
          else
            for (int i = ni - 2; i >= 0; --i) d[i] = smaller(d[i + 1] + std::fabs(here[i] - here[i + 1]) + along, d[i]);
          for (int i = 0; i < ni; ++i) changed |= d[i] < before[i] - 1e-6f;
        }
      }
    }
  }
}

}  // namespace simplexseg
