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

  // A tile with a voxel more on every side, in the team's own memory: its distances, twice, so that a round reads what
  // the one before wrote, then its image.
  static constexpr int kRow = kTileI + 2, kPlane = kRow * (kTileJ + 2), kHalo = kPlane * (kTileK + 2);
  static constexpr int kScratch = 3 * kHalo;
  static constexpr float kBeyond = 1e30f;  // of what lies beyond the grid

  SIMPLEXSEG_HD float lowest(const Field& field, const float* distance, const float* look, int at) const {
    float least = distance[at];
    const float here = look[at];
    SIMPLEXSEG_UNROLL_ALL
    for (int dk = -1; dk <= 1; ++dk) {
      SIMPLEXSEG_UNROLL_ALL
      for (int dj = -1; dj <= 1; ++dj) {
        SIMPLEXSEG_UNROLL_ALL
        for (int di = -1; di <= 1; ++di) {
          const int u = at + dk * kPlane + dj * kRow + di;
          const float difference = here - look[u];
          const float cost = field.edge2 > 0 ? cost_of_difference<true>(difference, field.edge2)
                                             : cost_of_difference<false>(difference, 0);
          // A voxel's own way, which is 0 longer, changes nothing.
          const float way = field.length * far[(di != 0 ? 1 : 0) + (dj != 0 ? 2 : 0) + (dk != 0 ? 4 : 0)];
          least = smaller(distance[u] + cost + way, least);
        }
      }
    }
    return least;
  }
  SIMPLEXSEG_HD bool is_in_grid(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < grid.size[0] && j < grid.size[1] && k < grid.size[2];
  }

  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team, int t) const {
    constexpr int voxels = kTileI * kTileJ * kTileK;
    const Field field = fields[t % count];
    const int tile = t / count;
    const int first[3]{tile % tiles[0] * kTileI, tile / tiles[0] % tiles[1] * kTileJ,
                       tile / (tiles[0] * tiles[1]) * kTileK};
    float *distance = team.scratch, *next = distance + kHalo, *const look = next + kHalo;
    for (int u = team.thread; u < kHalo; u += team.threads) {
      const int i = first[0] - 1 + u % kRow, j = first[1] - 1 + u / kRow % (kTileJ + 2), k = first[2] - 1 + u / kPlane;
      const bool in = is_in_grid(i, j, k);
      const int v = (k * grid.size[1] + j) * grid.size[0] + i;
      distance[u] = next[u] = in ? field.distance[v] : kBeyond;
      look[u] = in ? image[v] : 0.0f;
    }
    team.sync();
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool here = false;
      for (int u = team.thread; u < voxels; u += team.threads) {
        const int i = u % kTileI, j = u / kTileI % kTileJ, k = u / (kTileI * kTileJ);
        const int at = (k + 1) * kPlane + (j + 1) * kRow + i + 1;
        if (distance[at] == kBeyond) continue;
        const float least = lowest(field, distance, look, at);
        next[at] = least;
        here = here || least < distance[at];
      }
      if (!team.any(here)) break;
      any = true;
      float* const was = distance;
      distance = next;
      next = was;
    }
    if (!any) return;
    for (int u = team.thread; u < voxels; u += team.threads) {
      const int i = u % kTileI, j = u / kTileI % kTileJ, k = u / (kTileI * kTileJ);
      if (is_in_grid(first[0] + i, first[1] + j, first[2] + k))
        field.distance[((first[2] + k) * grid.size[1] + first[1] + j) * grid.size[0] + first[0] + i] =
            distance[(k + 1) * kPlane + (j + 1) * kRow + i + 1];
    }
    if (changed && team.thread == 0) *changed = 1;
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
