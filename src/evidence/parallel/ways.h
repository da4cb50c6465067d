// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>

#include "evidence/geodesic_distance.h"
#include "evidence/parallel/known.h"

namespace simplexseg {

/// Geodesic distances of one image that are lowered together; a team for each tile of each of them.
struct LowerWays {
  static constexpr int kMost = 3;
  static constexpr int kRounds = 16;  // of a tile at most, before it looks at what its neighbours have become
  static constexpr int kTileI = 16, kTileJ = 8, kTileK = 8;

  struct Field {
    float* distance;
    float length, edge2;
  };
  BoxGrid grid;
  std::array<int, 3> tiles;
  const float* image;
  float far[8];  ///< of neighbours with 1: another i, 2: another j, 4: another k, in units of the least spacing
  std::array<Field, kMost> fields;
  int count;
  int* changed;  ///< 1 is written where anything became less; or null

  SIMPLEXSEG_HD float lowest(const Field& field, const GridPlace& p, int v) const {
    float least = field.distance[v];
    const float here = image[v];
    SIMPLEXSEG_UNROLL_ALL
    for (int dk = -1; dk <= 1; ++dk) {
      if (p.k + dk < 0 || p.k + dk >= grid.size[2]) continue;
      SIMPLEXSEG_UNROLL_ALL
      for (int dj = -1; dj <= 1; ++dj) {
        if (p.j + dj < 0 || p.j + dj >= grid.size[1]) continue;
        SIMPLEXSEG_UNROLL_ALL
        for (int di = -1; di <= 1; ++di) {
          if (p.i + di < 0 || p.i + di >= grid.size[0]) continue;
          const int u = v + dk * grid.plane() + dj * grid.row() + di;
          const float difference = here - image[u];
          const float cost = field.edge2 > 0 ? cost_of_difference<true>(difference, field.edge2)
                                             : cost_of_difference<false>(difference, 0);
          // A voxel's own way, which is 0 longer, changes nothing.
          const float way = field.length * far[(di != 0 ? 1 : 0) + (dj != 0 ? 2 : 0) + (dk != 0 ? 4 : 0)];
          least = smaller(field.distance[u] + cost + way, least);
        }
      }
    }
    return least;
  }

  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team, int t) const {
    const Field field = fields[t % count];
    const int tile = t / count;
    const int first[3]{tile % tiles[0] * kTileI, tile / tiles[0] % tiles[1] * kTileJ,
                       tile / (tiles[0] * tiles[1]) * kTileK};
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool here = false;
      for (int u = team.thread; u < kTileI * kTileJ * kTileK; u += team.threads) {
        const int i = first[0] + u % kTileI, j = first[1] + u / kTileI % kTileJ, k = first[2] + u / (kTileI * kTileJ);
        if (i >= grid.size[0] || j >= grid.size[1] || k >= grid.size[2]) continue;
        const int v = (k * grid.size[1] + j) * grid.size[0] + i;
        const float least = lowest(field, GridPlace(grid, v), v);
        if (!(least < field.distance[v])) continue;
        field.distance[v] = least;
        here = true;
      }
      if (!team.any(here)) break;
      any = true;
    }
    if (any && changed && team.thread == 0) *changed = 1;
  }
};

/// lower_geodesic_distance() to the end, for some distances together: over the 26 neighbours nothing can be lowered any
/// more. In whatever order voxels are looked at, that is the same, bit by bit: what a voxel takes from a neighbour only
/// falls when the neighbour's falls.
template <class Executor>
class ParallelWays {
 public:
  ParallelWays(const Executor& executor, const BoxGrid& grid, const std::array<double, 3>& spacing_mm,
               const float* image)
      : executor_(executor), changed_(executor.template array<int>(1)) {
    lower_.grid = grid;
    lower_.image = image;
    const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
    for (int axes = 0; axes < 8; ++axes) {
      double square = 0;
      for (int a = 0; a < 3; ++a)
        if (axes >> a & 1) square += spacing_mm[a] / least * (spacing_mm[a] / least);
      lower_.far[axes] = static_cast<float>(std::sqrt(square));
    }
    const std::array tile{LowerWays::kTileI, LowerWays::kTileJ, LowerWays::kTileK};
    for (int a = 0; a < 3; ++a) lower_.tiles[a] = (grid.size[a] + tile[a] - 1) / tile[a];
  }

  struct Way {
    float* distance;
    WayCost cost;
  };
  /// Starts with at most LowerWays::kMost of them; until finish() they are not what they will be.
  void begin(std::initializer_list<Way> ways) {
    lower_.count = 0;
    for (const Way& way : ways)
      lower_.fields[lower_.count++] = {way.distance, way.cost.length, way.cost.edge * way.cost.edge};
    executor_.clear(changed_.data(), 1);
    const int longest = *std::max_element(lower_.grid.size.begin(), lower_.grid.size.end());
    launch(2 + longest / LowerWays::kRounds);
  }
  void finish() {
    while (value_at(executor_, changed_.data()) != 0) {
      executor_.clear(changed_.data(), 1);
      launch(2);
    }
  }
  std::size_t bytes() const { return changed_.bytes(); }

 private:
  /// The last one says whether that was enough.
  void launch(int times) {
    const int teams = lower_.count * lower_.tiles[0] * lower_.tiles[1] * lower_.tiles[2];
    for (int t = 0; t < times; ++t) {
      lower_.changed = t + 1 == times ? changed_.data() : nullptr;
      executor_.teams(teams, lower_);
    }
  }

  const Executor& executor_;
  LowerWays lower_{};
  typename Executor::template Array<int> changed_;
};

}  // namespace simplexseg
