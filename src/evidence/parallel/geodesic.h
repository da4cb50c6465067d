// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "core/atomics.h"
#include "evidence/geodesic_distance.h"
#include "evidence/parallel/constraints.h"

namespace simplexseg {

/// Geodesic distances of one image that are lowered together; a team for each tile of each of them. What the ways
/// between neighbours cost is worked out once by each thread and kept, for as many rounds as the tile needs.
struct LowerWays {
  static constexpr int kMost = 5;
  static constexpr int kRounds = 16;  // of a tile at most, before it looks at what its neighbours have become
  static constexpr int kTile = 8, kVoxels = kTile * kTile * kTile;

  struct Field {
    float* distance;
    float length, edge2;
    /// For each tile the launch in which something became less there; 0 before the first, which is launch 1.
    int* lowered;
  };
  BoxGrid grid;
  std::array<int, 3> tiles;
  const float* image;
  float far[8];  ///< of neighbours with 1: another i, 2: another j, 4: another k, in units of the least spacing
  std::array<Field, kMost> fields;
  int count;
  int launch;
  int* changed;  ///< 1 is written where anything became less; or null

  // A tile with a voxel more on every side, in the team's own memory: its distances, twice, so that a round reads what
  // the one before wrote, then its image. Rows so far apart that the threads of a warp meet in no bank.
  static constexpr int kSide = kTile + 2, kRow = 24, kPlane = kRow * kSide, kHalo = kPlane * kSide;
  static constexpr int kScratch = 3 * kHalo;
  static constexpr float kBeyond = 1e30f;  // of what lies beyond the grid

  using Costs = std::array<float, 27>;
  /// visit(n, from a voxel's place in the scratch to its neighbour's, index of `far`) for the 26 neighbours.
  template <class Visit>
  static SIMPLEXSEG_HD void each_neighbour(const Visit& visit) {
    SIMPLEXSEG_UNROLL_ALL
    for (int dk = -1; dk <= 1; ++dk) {
      SIMPLEXSEG_UNROLL_ALL
      for (int dj = -1; dj <= 1; ++dj) {
        SIMPLEXSEG_UNROLL_ALL
        for (int di = -1; di <= 1; ++di) {
          const int axes = (di != 0 ? 1 : 0) + (dj != 0 ? 2 : 0) + (dk != 0 ? 4 : 0);
          if (axes != 0) visit(9 * dk + 3 * dj + di + 13, dk * kPlane + dj * kRow + di, axes);
        }
      }
    }
  }
  SIMPLEXSEG_HD void find_costs(const Field& field, const float* look, Costs& costs) const {
    const float here = *look;
    each_neighbour([&](int n, int to, int axes) {
      const float difference = here - look[to];
      const float cost = field.edge2 > 0 ? cost_of_difference<true>(difference, field.edge2)
                                         : cost_of_difference<false>(difference, 0);
      costs[n] = cost + field.length * far[axes];
    });
  }
  static SIMPLEXSEG_HD float lowest(const float* distance, const Costs& costs) {
    float least = *distance;
    each_neighbour([&](int n, int to, int) { least = smaller(distance[to] + costs[n], least); });
    return least;
  }

  SIMPLEXSEG_HD bool is_in_grid(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < grid.size[0] && j < grid.size[1] && k < grid.size[2];
  }
  /// Whether a tile or one beside it has lowered anything in the launch before this one.
  template <class Team>
  SIMPLEXSEG_HD bool has_news(const Team& team, const Field& field, const int (&tile)[3]) const {
    bool news = false;
    for (int n = team.thread; n < 27; n += Team::threads) {
      const int i = tile[0] + n % 3 - 1, j = tile[1] + n / 3 % 3 - 1, k = tile[2] + n / 9 - 1;
      if (i < 0 || j < 0 || k < 0 || i >= tiles[0] || j >= tiles[1] || k >= tiles[2]) continue;
      news = news || load_relaxed(field.lowered + (k * tiles[1] + j) * tiles[0] + i) >= launch - 1;
    }
    return team.any(news);
  }

  template <class Team>
  SIMPLEXSEG_HD void operator()(const Team& team, int t) const {
    constexpr int own = (kVoxels + Team::threads - 1) / Team::threads;  // voxels of a thread
    const Field field = fields[t % count];
    const int tile = t / count;
    const int at_tile[3]{tile % tiles[0], tile / tiles[0] % tiles[1], tile / (tiles[0] * tiles[1])};
    if (!has_news(team, field, at_tile)) return;
    const int first[3]{at_tile[0] * kTile, at_tile[1] * kTile, at_tile[2] * kTile};
    float *distance = team.scratch, *next = distance + kHalo, *const look = next + kHalo;
    for (int u = team.thread; u < kSide * kSide * kSide; u += Team::threads) {
      const int di = u % kSide, dj = u / kSide % kSide, dk = u / (kSide * kSide), at = dk * kPlane + dj * kRow + di;
      const int i = first[0] - 1 + di, j = first[1] - 1 + dj, k = first[2] - 1 + dk;
      const bool in = is_in_grid(i, j, k);
      const int v = (k * grid.size[1] + j) * grid.size[0] + i;
      distance[at] = next[at] = in ? field.distance[v] : kBeyond;
      look[at] = in ? image[v] : 0.0f;
    }
    team.sync();
    int place[own];  // in the scratch; -1 beyond the grid
    Costs costs[own];
    SIMPLEXSEG_UNROLL_ALL
    for (int o = 0; o < own; ++o) {
      const int u = team.thread + o * Team::threads, i = u % kTile, j = u / kTile % kTile, k = u / (kTile * kTile);
      const bool in = u < kVoxels && is_in_grid(first[0] + i, first[1] + j, first[2] + k);
      place[o] = in ? (k + 1) * kPlane + (j + 1) * kRow + i + 1 : -1;
      if (in) find_costs(field, look + place[o], costs[o]);
    }
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool here = false;
      SIMPLEXSEG_UNROLL_ALL
      for (int o = 0; o < own; ++o) {
        if (place[o] < 0) continue;
        const float least = lowest(distance + place[o], costs[o]);
        next[place[o]] = least;
        here = here || least < distance[place[o]];
      }
      if (!team.any(here)) break;
      any = true;
      float* const was = distance;
      distance = next;
      next = was;
    }
    if (!any) return;
    SIMPLEXSEG_UNROLL_ALL
    for (int o = 0; o < own; ++o) {
      if (place[o] < 0) continue;
      const int u = team.thread + o * Team::threads, i = u % kTile, j = u / kTile % kTile, k = u / (kTile * kTile);
      field.distance[((first[2] + k) * grid.size[1] + first[1] + j) * grid.size[0] + first[0] + i] = distance[place[o]];
    }
    if (team.thread != 0) return;
    atomic_max(field.lowered + tile, launch);
    if (changed) *changed = 1;
  }
};

/// lower_geodesic_distance() to the end, for some distances together: over the 26 neighbours nothing can be lowered any
/// more. In whatever order voxels are looked at, that is the same, bit by bit: what a voxel takes from a neighbour only
/// falls when the neighbour's falls.
template <class Executor>
class ParallelGeodesic {
 public:
  ParallelGeodesic(const Executor& executor, const BoxGrid& grid, const std::array<double, 3>& spacing_mm,
                   const float* image)
      : executor_(executor) {
    lower_.grid = grid;
    lower_.image = image;
    const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
    for (int axes = 0; axes < 8; ++axes) {
      double square = 0;
      for (int a = 0; a < 3; ++a)
        if (axes >> a & 1) square += spacing_mm[a] / least * (spacing_mm[a] / least);
      lower_.far[axes] = static_cast<float>(std::sqrt(square));
    }
    for (int a = 0; a < 3; ++a) lower_.tiles[a] = (grid.size[a] + LowerWays::kTile - 1) / LowerWays::kTile;
    lowered_ = executor.template array<int>(1 + std::size_t(LowerWays::kMost) * tiles());
  }

  struct Distance {
    float* distance;
    EdgeCost cost;
  };
  /// Starts with at most LowerWays::kMost of them; until finish() they are not what they will be.
  void begin(std::span<const Distance> ways) {
    lower_.count = lower_.launch = 0;
    for (const Distance& way : ways) {
      lower_.fields[lower_.count] = {way.distance, way.cost.length, way.cost.edge * way.cost.edge,
                                     lowered_.data() + 1 + lower_.count * tiles()};
      ++lower_.count;
    }
    executor_.clear(lowered_.data(), 1 + std::size_t(lower_.count) * tiles());
    const int longest = *std::max_element(lower_.tiles.begin(), lower_.tiles.end());
    launch(kMoreAtOnce * ((longest + kTurns) / kMoreAtOnce + 1));
  }
  void finish() {
    while (received<int>(executor_, changed_) != 0) {
      executor_.clear(lowered_.data(), 1);
      launch(kMoreAtOnce);
    }
  }
  std::size_t bytes() const { return lowered_.bytes(); }

 private:
  static constexpr int kMoreAtOnce = 4;  ///< launches that are begun before it is asked whether anything changed
  static constexpr int kTurns = 8;       ///< tiles that ways lead through beside those of the longest axis, mostly

  int tiles() const { return lower_.tiles[0] * lower_.tiles[1] * lower_.tiles[2]; }
  /// The last one says whether that was enough.
  void launch(int times) {
    for (int t = 0; t < times; ++t) {
      ++lower_.launch;
      lower_.changed = t + 1 == times ? lowered_.data() : nullptr;
      executor_.teams(lower_.count * tiles(), lower_);
    }
    changed_ = executor_.fetch(lowered_.data(), 1);
  }

  const Executor& executor_;
  LowerWays lower_{};
  typename Executor::template Fetched<int> changed_;
  typename Executor::template Array<int> lowered_;  ///< whether anything changed, then LowerWays::Field::lowered
};

}  // namespace simplexseg
