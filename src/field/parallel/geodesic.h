// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <type_traits>

#include "core/atomics.h"
#include "field/geodesic_distance.h"
#include "field/parallel/constraints.h"

namespace simplexseg {

/// Largest number of geodesic distances that are lowered together.
inline constexpr int kMostDistances = 5;

/// Lowers geodesic distances of one image on a device, by one team for each tile of each distance. Costs of the paths
/// between neighbours are computed once by each thread, for all rounds of the tile.
struct LowerTiles {
  static constexpr int kRounds = 16;  // of a tile at most, before it reads its neighbours again
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
  std::array<Field, kMostDistances> fields;
  int count;
  int launch;
  int* changed;  ///< 1 is written where anything became less; or null

  // A tile with a cell more on every side, in the memory of the team: its distances, twice, so that a round reads the
  // results of the one before, then its image. Rows of 24: the threads of a warp access different banks.
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
    float lengths[8];
    for (int axes = 0; axes < 8; ++axes) lengths[axes] = field.length * far[axes];
    each_neighbour([&](int n, int to, int axes) {
      const float difference = here - look[to];
      const float cost = field.edge2 > 0 ? cost_of_difference<true>(difference, field.edge2)
                                         : cost_of_difference<false>(difference, 0);
      costs[n] = cost + lengths[axes];
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

/// The same on the CPU, by one team for each slab of planes, which scans its rows in both directions, in place, until
/// nothing changes. Even and odd slabs take turns, so that no other team changes the planes beside a slab. Rows are
/// skipped while nothing changed beside them. Source: Toivanen 1996, New geodesic distance transforms for gray-scale
/// images.
struct LowerSlabs {
  static constexpr int kLeastPlanes = 8, kMostSlabs = 4, kRounds = 4, kScratch = 1;

  struct Field {
    float* distance;
    float length, edge2;
    int* changed;  ///< for each row the scan at which it changed last
    int* scanned;  ///< for each slab the last scans forward and backward
  };
  BoxGrid grid;
  const float* image;
  float far[8];  ///< LowerTiles::far
  std::array<Field, kMostDistances> fields;
  int count;
  int parity;    ///< of the slabs of this launch
  int scan;      ///< number of the first scan of this launch
  int* lowered;  ///< 1 is written if anything became less

  static int planes(const BoxGrid& grid) {
    return std::max(kLeastPlanes, (grid.size[2] + kMostSlabs - 1) / kMostSlabs);
  }
  static int slabs(const BoxGrid& grid) { return (grid.size[2] + planes(grid) - 1) / planes(grid); }

  void operator()(const SerialBlock&, int t) const {
    const Field& field = fields[t % count];
    const int slab = 2 * (t / count) + parity;
    if (slab >= slabs(grid)) return;
    const bool any = field.edge2 > 0 ? lower<true>(field, slab) : lower<false>(field, slab);
    if (any) store_relaxed(lowered, 1);
  }

 private:
  template <bool kEdges>
  bool lower(const Field& field, int slab) const {
    const int begin = slab * planes(grid), end = smaller(begin + planes(grid), grid.size[2]), rows = grid.size[1];
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool changed = false;
      for (const int way : {1, -1}) {
        const int now = scan + 2 * round + (way < 0);
        int& last = field.scanned[2 * slab + (way < 0)];
        for (int kk = begin; kk < end; ++kk)
          for (int jj = 0; jj < rows; ++jj) {
            const int k = way > 0 ? kk : begin + end - 1 - kk, j = way > 0 ? jj : rows - 1 - jj;
            changed |= lower_row<kEdges>(field, j, k, way, now, last);
          }
        last = now;
      }
      if (!changed) break;
      any = true;
    }
    return any;
  }
  template <bool kEdges>
  bool lower_row(const Field& field, int j, int k, int way, int now, int last) const {
    constexpr int other[4][2]{{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};  // dj, dk of rows that were scanned before
    const int n = grid.size[0], row = k * grid.size[1] + j;
    int from[4], sides = 0, axes[4];
    bool needed = field.changed[row] > last;
    for (const auto& [dj, dk] : other) {
      const int jo = dk == 0 ? j + dj * way : j + dj, ko = k + dk * way;
      if (jo < 0 || ko < 0 || jo >= grid.size[1] || ko >= grid.size[2]) continue;
      axes[sides] = (dj != 0 ? 2 : 0) + (dk != 0 ? 4 : 0);
      from[sides++] = ko * grid.size[1] + jo;
      needed |= field.changed[ko * grid.size[1] + jo] > last;
    }
    if (!needed) return false;
    float* const to = field.distance + std::size_t(row) * n;
    const float* const here = image + std::size_t(row) * n;
    bool changed = false;
    for (int s = 0; s < sides; ++s)
      changed |= take_row<kEdges>(field, to, here, field.distance + std::size_t(from[s]) * n,
                                  image + std::size_t(from[s]) * n, axes[s]);
    changed |= scan_along<kEdges>(field, to, here, way);
    if (changed) field.changed[row] = now;
    return changed;
  }
  /// Lowers a row by paths from another row.
  template <bool kEdges>
  bool take_row(const Field& field, float* to, const float* here, const float* from, const float* there,
                int axes) const {
    const int n = grid.size[0];
    const float straight = field.length * far[axes], slant = field.length * far[axes + 1], edge2 = field.edge2;
    const auto offer = [=](int i, int o) {
      return from[i + o] + (cost_of_difference<kEdges>(here[i] - there[i + o], edge2) + (o == 0 ? straight : slant));
    };
    int changed = 0;
    const auto lower_to = [&](int i, float least) {
      changed |= least < to[i];
      to[i] = smaller(least, to[i]);
    };
    lower_to(0, offer(0, 0));
    if (n > 1) lower_to(0, offer(0, 1));
#pragma GCC ivdep
    for (int i = 1; i < n - 1; ++i) {
      // In this order, an offer that is NaN is ignored.
      const float was = to[i], least = smaller(offer(i, -1), smaller(offer(i, 1), smaller(offer(i, 0), was)));
      changed |= least < was;
      to[i] = least;
    }
    if (n > 1) lower_to(n - 1, offer(n - 1, 0)), lower_to(n - 1, offer(n - 1, -1));
    return changed != 0;
  }
  template <bool kEdges>
  bool scan_along(const Field& field, float* to, const float* here, int way) const {
    const int n = grid.size[0];
    const float length = field.length * far[1];
    bool changed = false;
    for (int step = 1, i = way > 0 ? 1 : n - 2; step < n; ++step, i += way) {
      const float least = to[i - way] + (cost_of_difference<kEdges>(here[i] - here[i - way], field.edge2) + length);
      changed |= least < to[i];
      to[i] = smaller(least, to[i]);
    }
    return changed;
  }
};

/// Geodesic distances over the 26 neighbours, several at a time: each is lowered until no neighbour can lower it. The
/// result does not depend on the order in which cells are visited, bit by bit, since a cell can only be lowered when a
/// neighbour was. Cells where `image` is NaN are not passed.
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
    if constexpr (!kBySlabs)
      for (int a = 0; a < 3; ++a) lower_.tiles[a] = (grid.size[a] + LowerTiles::kTile - 1) / LowerTiles::kTile;
    state_ = executor.template array<int>(1 + std::size_t(kMostDistances) * state_of_one());
  }

  struct Distance {
    float* distance;  ///< 0 at the sources and large elsewhere, or an earlier distance with new zeros
    EdgeCost cost;
  };
  /// Starts with at most kMostDistances of them; until finish() they are not complete.
  void begin(std::span<const Distance> distances) {
    lower_.count = 0;
    for (const Distance& one : distances) {
      int* const state = state_.data() + 1 + lower_.count * state_of_one();
      if constexpr (kBySlabs)
        lower_.fields[lower_.count] = {one.distance, one.cost.length, one.cost.edge * one.cost.edge, state,
                                       state + rows()};
      else
        lower_.fields[lower_.count] = {one.distance, one.cost.length, one.cost.edge * one.cost.edge, state};
      ++lower_.count;
    }
    executor_.clear(state_.data(), 1 + std::size_t(lower_.count) * state_of_one());
    if constexpr (kBySlabs) {
      for (int f = 0; f < lower_.count; ++f) std::fill_n(lower_.fields[f].changed, rows(), 1);
      lower_.scan = 2;
    } else {
      lower_.launch = 0;
      const int longest = *std::max_element(lower_.tiles.begin(), lower_.tiles.end());
      launch(kMoreAtOnce * ((longest + kTurns) / kMoreAtOnce + 1));
    }
  }
  void finish() {
    if constexpr (kBySlabs) {
      lower_.lowered = state_.data();
      do {
        state_.data()[0] = 0;
        for (lower_.parity = 0; lower_.parity < 2; ++lower_.parity) {
          executor_.teams(lower_.count * ((LowerSlabs::slabs(lower_.grid) + 1) / 2), lower_);
          lower_.scan += 2 * LowerSlabs::kRounds;
        }
      } while (state_.data()[0] != 0);
    } else {
      while (received<int>(executor_, changed_) != 0) {
        executor_.clear(state_.data(), 1);
        launch(kMoreAtOnce);
      }
    }
  }
  std::size_t bytes() const { return state_.bytes(); }

 private:
  static constexpr bool kBySlabs = Executor::kCellsInOrder;
  static constexpr int kMoreAtOnce = 4;  ///< launches that are begun before the host asks whether anything changed
  static constexpr int kTurns = 8;       ///< usual number of tiles on a path beyond those of the longest axis

  int rows() const { return lower_.grid.size[1] * lower_.grid.size[2]; }
  /// Number of values of the state of a distance.
  int state_of_one() const {
    if constexpr (kBySlabs)
      return rows() + 2 * LowerSlabs::slabs(lower_.grid);
    else
      return lower_.tiles[0] * lower_.tiles[1] * lower_.tiles[2];
  }
  /// The last launch reports whether the launches were enough.
  void launch(int times) {
    for (int t = 0; t < times; ++t) {
      ++lower_.launch;
      lower_.changed = t + 1 == times ? state_.data() : nullptr;
      executor_.teams(lower_.count * state_of_one(), lower_);
    }
    changed_ = executor_.fetch(state_.data(), 1);
  }

  const Executor& executor_;
  std::conditional_t<kBySlabs, LowerSlabs, LowerTiles> lower_{};
  typename Executor::template Fetched<int> changed_;
  typename Executor::template Array<int> state_;  ///< whether anything changed, then the state of each distance
};

}  // namespace simplexseg
