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

/// Largest number of geodesic distances that are relaxed together.
inline constexpr int kMostDistances = 5;

/// Relaxation of geodesic distances of one image on a device, by one block for each tile of each distance. Edge costs
/// are computed once by each thread, for all rounds of the tile.
struct RelaxTiles {
  static constexpr int kRounds = 16;  // most rounds of a tile in a launch
  static constexpr int kTile = 8, kVoxels = kTile * kTile * kTile;

  struct Field {
    float* distance;
    float length, edge2;
    /// For each tile the last launch that changed it; 0 before the first launch, which has the number 1.
    int* last_change;
  };
  BoxGrid grid;
  std::array<int, 3> tiles;
  const float* image;
  float far[8];  ///< distance of neighbours that differ in i (1), j (2), k (4), in units of the smallest spacing
  std::array<Field, kMostDistances> fields;
  int count;
  int launch;
  int* any_change;  ///< 1 is written if a distance changed; or null

  // Memory of a block: the distances of its tile with a halo of one cell, in two copies, so that a round reads the
  // results of the one before, and its image. Rows of 24: the threads of a warp access different banks.
  static constexpr int kSide = kTile + 2, kRow = 24, kPlane = kRow * kSide, kHalo = kPlane * kSide;
  static constexpr int kScratch = 3 * kHalo;
  static constexpr float kBeyond = 1e30f;  // distance beyond the grid

  using Costs = std::array<float, 27>;
  /// Calls visit(n, offset in the scratch, index of `far`) for the 26 neighbours of a voxel.
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
  SIMPLEXSEG_HD void find_costs(const Field& field, const float* intensity, Costs& costs) const {
    const float here = *intensity;
    float lengths[8];
    for (int axes = 0; axes < 8; ++axes) lengths[axes] = field.length * far[axes];
    each_neighbour([&](int n, int to, int axes) {
      const float difference = here - intensity[to];
      const float cost = field.edge2 > 0 ? cost_of_difference<true>(difference, field.edge2)
                                         : cost_of_difference<false>(difference, 0);
      costs[n] = cost + lengths[axes];
    });
  }
  static SIMPLEXSEG_HD float relaxed_distance(const float* distance, const Costs& costs) {
    float least = *distance;
    each_neighbour([&](int n, int to, int) { least = smaller(distance[to] + costs[n], least); });
    return least;
  }

  SIMPLEXSEG_HD bool is_in_grid(int i, int j, int k) const {
    return i >= 0 && j >= 0 && k >= 0 && i < grid.size[0] && j < grid.size[1] && k < grid.size[2];
  }
  /// Whether the last launch changed a tile or one of its neighbours.
  template <class Block>
  SIMPLEXSEG_HD bool has_changes(const Block& block, const Field& field, const int (&tile)[3]) const {
    bool changes = false;
    for (int n = block.thread; n < 27; n += Block::threads) {
      const int i = tile[0] + n % 3 - 1, j = tile[1] + n / 3 % 3 - 1, k = tile[2] + n / 9 - 1;
      if (i < 0 || j < 0 || k < 0 || i >= tiles[0] || j >= tiles[1] || k >= tiles[2]) continue;
      changes = changes || load_relaxed(field.last_change + (k * tiles[1] + j) * tiles[0] + i) >= launch - 1;
    }
    return block.any(changes);
  }

  template <class Block>
  SIMPLEXSEG_HD void operator()(const Block& block, int t) const {
    constexpr int own = (kVoxels + Block::threads - 1) / Block::threads;  // voxels of a thread
    const Field field = fields[t % count];
    const int tile = t / count;
    const int at_tile[3]{tile % tiles[0], tile / tiles[0] % tiles[1], tile / (tiles[0] * tiles[1])};
    if (!has_changes(block, field, at_tile)) return;
    const int first[3]{at_tile[0] * kTile, at_tile[1] * kTile, at_tile[2] * kTile};
    float *distance = block.scratch, *next = distance + kHalo, *const intensity = next + kHalo;
    for (int u = block.thread; u < kSide * kSide * kSide; u += Block::threads) {
      const int di = u % kSide, dj = u / kSide % kSide, dk = u / (kSide * kSide), at = dk * kPlane + dj * kRow + di;
      const int i = first[0] - 1 + di, j = first[1] - 1 + dj, k = first[2] - 1 + dk;
      const bool in = is_in_grid(i, j, k);
      const int v = (k * grid.size[1] + j) * grid.size[0] + i;
      distance[at] = next[at] = in ? field.distance[v] : kBeyond;
      intensity[at] = in ? image[v] : 0.0f;
    }
    block.sync();
    int place[own];  // index in the scratch; -1 beyond the grid
    Costs costs[own];
    SIMPLEXSEG_UNROLL_ALL
    for (int o = 0; o < own; ++o) {
      const int u = block.thread + o * Block::threads, i = u % kTile, j = u / kTile % kTile, k = u / (kTile * kTile);
      const bool in = u < kVoxels && is_in_grid(first[0] + i, first[1] + j, first[2] + k);
      place[o] = in ? (k + 1) * kPlane + (j + 1) * kRow + i + 1 : -1;
      if (in) find_costs(field, intensity + place[o], costs[o]);
    }
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool here = false;
      SIMPLEXSEG_UNROLL_ALL
      for (int o = 0; o < own; ++o) {
        if (place[o] < 0) continue;
        const float least = relaxed_distance(distance + place[o], costs[o]);
        next[place[o]] = least;
        here = here || least < distance[place[o]];
      }
      if (!block.any(here)) break;
      any = true;
      float* const previous = distance;
      distance = next;
      next = previous;
    }
    if (!any) return;
    SIMPLEXSEG_UNROLL_ALL
    for (int o = 0; o < own; ++o) {
      if (place[o] < 0) continue;
      const int u = block.thread + o * Block::threads, i = u % kTile, j = u / kTile % kTile, k = u / (kTile * kTile);
      field.distance[((first[2] + k) * grid.size[1] + first[1] + j) * grid.size[0] + first[0] + i] = distance[place[o]];
    }
    if (block.thread != 0) return;
    atomic_max(field.last_change + tile, launch);
    if (any_change) *any_change = 1;
  }
};

/// Relaxation of geodesic distances on the CPU, by one block for each slab of planes, which scans its rows in both
/// directions, in place, until nothing changes. Launches of even and odd slabs alternate, so that the planes beside a
/// slab do not change. Rows are skipped if their neighbours did not change. Source: Toivanen 1996, New geodesic
/// distance transforms for gray-scale images.
struct RelaxSlabs {
  static constexpr int kLeastPlanes = 8, kMostSlabs = 4, kRounds = 4, kScratch = 1;

  struct Field {
    float* distance;
    float length, edge2;
    int* changed;  ///< for each row the last scan that changed it
    int* scanned;  ///< for each slab the last forward and the last backward scan
  };
  BoxGrid grid;
  const float* image;
  float far[8];  ///< RelaxTiles::far
  std::array<Field, kMostDistances> fields;
  int count;
  int parity;       ///< of the slabs of this launch
  int scan;         ///< number of the first scan of this launch
  int* any_change;  ///< 1 is written if a distance changed

  static int planes(const BoxGrid& grid) {
    return std::max(kLeastPlanes, (grid.size[2] + kMostSlabs - 1) / kMostSlabs);
  }
  static int slabs(const BoxGrid& grid) { return (grid.size[2] + planes(grid) - 1) / planes(grid); }

  void operator()(const SerialBlock&, int t) const {
    const Field& field = fields[t % count];
    const int slab = 2 * (t / count) + parity;
    if (slab >= slabs(grid)) return;
    const bool any = field.edge2 > 0 ? relax<true>(field, slab) : relax<false>(field, slab);
    if (any) store_relaxed(any_change, 1);
  }

 private:
  template <bool kEdges>
  bool relax(const Field& field, int slab) const {
    const int begin = slab * planes(grid), end = smaller(begin + planes(grid), grid.size[2]), rows = grid.size[1];
    bool any = false;
    for (int round = 0; round < kRounds; ++round) {
      bool changed = false;
      for (const int direction : {1, -1}) {
        const int now = scan + 2 * round + (direction < 0);
        int& last = field.scanned[2 * slab + (direction < 0)];
        for (int kk = begin; kk < end; ++kk)
          for (int jj = 0; jj < rows; ++jj) {
            const int k = direction > 0 ? kk : begin + end - 1 - kk, j = direction > 0 ? jj : rows - 1 - jj;
            changed |= relax_row<kEdges>(field, j, k, direction, now, last);
          }
        last = now;
      }
      if (!changed) break;
      any = true;
    }
    return any;
  }
  template <bool kEdges>
  bool relax_row(const Field& field, int j, int k, int direction, int now, int last) const {
    constexpr int other[4][2]{{-1, 0}, {-1, -1}, {0, -1}, {1, -1}};  // dj, dk of rows that were scanned earlier
    const int n = grid.size[0], row = k * grid.size[1] + j;
    int from[4], sides = 0, axes[4];
    bool needed = field.changed[row] > last;
    for (const auto& [dj, dk] : other) {
      const int jo = dk == 0 ? j + dj * direction : j + dj, ko = k + dk * direction;
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
      changed |= relax_from_row<kEdges>(field, to, here, field.distance + std::size_t(from[s]) * n,
                                        image + std::size_t(from[s]) * n, axes[s]);
    changed |= relax_along_row<kEdges>(field, to, here, direction);
    if (changed) field.changed[row] = now;
    return changed;
  }
  /// Relaxes a row by edges from another row.
  template <bool kEdges>
  bool relax_from_row(const Field& field, float* to, const float* here, const float* from, const float* there,
                      int axes) const {
    const int n = grid.size[0];
    const float straight = field.length * far[axes], slant = field.length * far[axes + 1], edge2 = field.edge2;
    const auto candidate = [=](int i, int o) {
      return from[i + o] + (cost_of_difference<kEdges>(here[i] - there[i + o], edge2) + (o == 0 ? straight : slant));
    };
    int changed = 0;
    const auto relax_to = [&](int i, float least) {
      changed |= least < to[i];
      to[i] = smaller(least, to[i]);
    };
    relax_to(0, candidate(0, 0));
    if (n > 1) relax_to(0, candidate(0, 1));
#pragma GCC ivdep
    for (int i = 1; i < n - 1; ++i) {
      // In this order, a candidate that is NaN is ignored.
      const float old = to[i],
                  least = smaller(candidate(i, -1), smaller(candidate(i, 1), smaller(candidate(i, 0), old)));
      changed |= least < old;
      to[i] = least;
    }
    if (n > 1) relax_to(n - 1, candidate(n - 1, 0)), relax_to(n - 1, candidate(n - 1, -1));
    return changed != 0;
  }
  template <bool kEdges>
  bool relax_along_row(const Field& field, float* to, const float* here, int direction) const {
    const int n = grid.size[0];
    const float length = field.length * far[1];
    bool changed = false;
    for (int step = 1, i = direction > 0 ? 1 : n - 2; step < n; ++step, i += direction) {
      const float least =
          to[i - direction] + (cost_of_difference<kEdges>(here[i] - here[i - direction], field.edge2) + length);
      changed |= least < to[i];
      to[i] = smaller(least, to[i]);
    }
    return changed;
  }
};

/// Geodesic distances over 26-neighbours, several together, by relaxation to convergence. The bits of the result do not
/// depend on the order of visits, since rounded sums along a path are monotonic. Paths do not cross cells where `image`
/// is NaN. Source: docs/mathematics.md 8.4.
template <class Executor>
class ParallelGeodesic {
 public:
  ParallelGeodesic(const Executor& executor, const BoxGrid& grid, const std::array<double, 3>& spacing_mm,
                   const float* image)
      : executor_(executor) {
    relax_.grid = grid;
    relax_.image = image;
    const double least = *std::min_element(spacing_mm.begin(), spacing_mm.end());
    for (int axes = 0; axes < 8; ++axes) {
      double square = 0;
      for (int a = 0; a < 3; ++a)
        if (axes >> a & 1) square += spacing_mm[a] / least * (spacing_mm[a] / least);
      relax_.far[axes] = static_cast<float>(std::sqrt(square));
    }
    if constexpr (!kBySlabs)
      for (int a = 0; a < 3; ++a) relax_.tiles[a] = (grid.size[a] + RelaxTiles::kTile - 1) / RelaxTiles::kTile;
    state_ = executor.template array<int>(1 + std::size_t(kMostDistances) * state_of_one());
  }

  struct Distance {
    float* distance;  ///< 0 at the sources and large elsewhere, or an earlier distance with further sources
    EdgeCost cost;
  };
  /// Begins the relaxation of at most kMostDistances distances; they are complete after finish().
  void begin(std::span<const Distance> distances) {
    relax_.count = 0;
    for (const Distance& one : distances) {
      int* const state = state_.data() + 1 + relax_.count * state_of_one();
      if constexpr (kBySlabs)
        relax_.fields[relax_.count] = {one.distance, one.cost.length, one.cost.edge * one.cost.edge, state,
                                       state + rows()};
      else
        relax_.fields[relax_.count] = {one.distance, one.cost.length, one.cost.edge * one.cost.edge, state};
      ++relax_.count;
    }
    executor_.clear(state_.data(), 1 + std::size_t(relax_.count) * state_of_one());
    if constexpr (kBySlabs) {
      for (int f = 0; f < relax_.count; ++f) std::fill_n(relax_.fields[f].changed, rows(), 1);
      relax_.scan = 2;
    } else {
      relax_.launch = 0;
      const int longest = *std::max_element(relax_.tiles.begin(), relax_.tiles.end());
      launch(kLaunchesPerQuery * ((longest + kTilesOfDetours) / kLaunchesPerQuery + 1));
    }
  }
  void finish() {
    if constexpr (kBySlabs) {
      relax_.any_change = state_.data();
      do {
        state_.data()[0] = 0;
        for (relax_.parity = 0; relax_.parity < 2; ++relax_.parity) {
          executor_.blocks(relax_.count * ((RelaxSlabs::slabs(relax_.grid) + 1) / 2), relax_);
          relax_.scan += 2 * RelaxSlabs::kRounds;
        }
      } while (state_.data()[0] != 0);
    } else {
      while (received<int>(executor_, changed_) != 0) {
        executor_.clear(state_.data(), 1);
        launch(kLaunchesPerQuery);
      }
    }
  }
  std::size_t bytes() const { return state_.bytes(); }

 private:
  static constexpr bool kBySlabs = Executor::kCellsInOrder;
  static constexpr int kLaunchesPerQuery = 4;  ///< launches between two queries of the host
  static constexpr int kTilesOfDetours = 8;    ///< usual number of tiles on a path beyond those of the longest axis

  int rows() const { return relax_.grid.size[1] * relax_.grid.size[2]; }
  /// Number of values in the state of a distance.
  int state_of_one() const {
    if constexpr (kBySlabs)
      return rows() + 2 * RelaxSlabs::slabs(relax_.grid);
    else
      return relax_.tiles[0] * relax_.tiles[1] * relax_.tiles[2];
  }
  /// Launches the relaxation; the last launch reports whether a distance changed.
  void launch(int times) {
    for (int t = 0; t < times; ++t) {
      ++relax_.launch;
      relax_.any_change = t + 1 == times ? state_.data() : nullptr;
      executor_.blocks(relax_.count * state_of_one(), relax_);
    }
    changed_ = executor_.fetch(state_.data(), 1);
  }

  const Executor& executor_;
  std::conditional_t<kBySlabs, RelaxSlabs, RelaxTiles> relax_{};
  typename Executor::template Fetched<int> changed_;
  typename Executor::template Array<int> state_;  ///< whether anything changed, then the state of each distance
};

}  // namespace simplexseg
