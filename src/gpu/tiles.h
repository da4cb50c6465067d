// SPDX-License-Identifier: Apache-2.0
// The vertices in tiles: some that lie together, and around them what a step of them reads. A device then does a step
// in one launch: each block finds the frames of its tile and of two rings around it by itself, in its own memory
// (docs/adr/0035-a-step-in-one-launch.md).
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gpu/kernels.h"

namespace simplexseg {

/// What a step of one tile reads. Slots count its vertices and those around: first its own, then rings 1 and 2 around
/// them, whose frames its forces read, then ring 3, whose positions these frames are made of.
struct Tile {
  int first, own;         ///< vertices of the tile
  int frames, positions;  ///< slots with a frame; all slots
  int around;             ///< in TilesView::around, of the first slot that is not its own
  int neighbours;         ///< in TilesView::neighbours, of slot 0
};
struct TilesView {
  const Tile* tiles = nullptr;
  const int* around = nullptr;                   ///< vertices
  const PackedNeighbours* neighbours = nullptr;  ///< of the slots with a frame, as differences of slots
  int count = 0, most_frames = 0, most_positions = 0;
};

struct TileArrays {
  std::vector<Tile> tiles;
  std::vector<int> around;
  std::vector<PackedNeighbours> neighbours;
  int most_frames = 0, most_positions = 0;
};

/// Vertices of a tile; of all meshes on which a force acts, beyond which two launches are faster; and of all meshes.
inline constexpr int kTileVertices = 64, kMostTiledVertices = 50'000, kMostInTiles = 500'000;

/// Tiles of vertices that follow each other. Empty where meshes are more than what 16 bits count.
inline TileArrays make_tiles(std::span<const Int4> neighbours) {
  constexpr int kFrameRings = 2;
  TileArrays all;
  const int n = static_cast<int>(neighbours.size());
  std::vector<int> slot(n), tile_of(n, -1);  // the slot holds in the tile that came there last
  std::vector<int> vertices;
  for (int first = 0; first < n; first += kTileVertices) {
    const int index = static_cast<int>(all.tiles.size());
    vertices.clear();
    auto take = [&](int i) {
      if (tile_of[i] == index) return;
      tile_of[i] = index, slot[i] = static_cast<int>(vertices.size());
      vertices.push_back(i);
    };
    const int own = std::min(kTileVertices, n - first);
    for (int i = first; i < first + own; ++i) take(i);
    int frames = 0;
    for (int ring = 0, begin = 0; ring <= kFrameRings; ++ring) {
      const int end = static_cast<int>(vertices.size());
      if (ring == kFrameRings) frames = end;
      for (int s = begin; s < end; ++s) {
        const Int4& nb = neighbours[vertices[s]];
        take(nb.x), take(nb.y), take(nb.z);
      }
      begin = end;
    }
    all.tiles.push_back({first, own, frames, static_cast<int>(vertices.size()), static_cast<int>(all.around.size()),
                         static_cast<int>(all.neighbours.size())});
    for (int s = 0; s < frames; ++s) {
      const Int4& nb = neighbours[vertices[s]];
      if (nb.w > std::numeric_limits<std::uint16_t>::max()) return {};
      auto difference = [&](int j) { return static_cast<std::int16_t>(slot[j] - s); };
      all.neighbours.push_back(
          {difference(nb.x), difference(nb.y), difference(nb.z), static_cast<std::uint16_t>(nb.w)});
    }
    all.around.insert(all.around.end(), vertices.begin() + own, vertices.end());
    all.most_frames = std::max(all.most_frames, frames);
    all.most_positions = std::max(all.most_positions, static_cast<int>(vertices.size()));
  }
  return all;
}

/// A whole step of the vertices of one tile: their frames and those around them, then the integration. Frames are read
/// of one array and written to another, for tiles find those around them, too. `shared`: memory of the team that is
/// called for the tile, shared_bytes() of it. Not for forces that pull, which are summed before.
template <unsigned kMask>
struct TileStep {
  static constexpr const char *name = IntegrateKernel<kMask, false>::name, *with = GeometryKernel::name;
  static constexpr int kThreads = 128;
  StepView v;
  TilesView tiles;
  OfRun of_run;
  End end;
  std::size_t shared_bytes() const {
    return (tiles.most_positions + tiles.most_frames) * sizeof(Vec4) + tiles.most_positions * sizeof(int);
  }
  template <class Team>
  SIMPLEXSEG_HD void operator()(int index, Team team, Vec4* shared) const {
    const Tile tile = tiles.tiles[index];
    Vec4 *positions = shared, *frames = shared + tiles.most_positions;
    int* vertices = reinterpret_cast<int*>(frames + tiles.most_frames);  // of slots
    const PackedNeighbours* neighbours = tiles.neighbours + tile.neighbours;
    // What no step changes, while the steps before are under way.
    for (int s = team.thread; s < tile.positions; s += Team::threads)
      vertices[s] = s < tile.own ? tile.first + s : tiles.around[tile.around + s - tile.own];
    team.wait_for_earlier_steps();
    for (int s = team.thread; s < tile.positions; s += Team::threads) positions[s] = v.current[vertices[s]];
    if (index == 0 && team.thread == 0) of_run.count(v.status);
    team.sync();
    StepView own = v;  // of slots
    own.first_vertex = tile.first;
    own.current = {positions}, own.frame = {frames}, own.new_frame = frames;
    own.neighbours = {nullptr, neighbours};
    for (int s = team.thread; s < tile.frames; s += Team::threads) {
      GeometryKernel::find_frame(own, s, [&](int) { return xyz(v.frame[vertices[s]]); });
      if (s < tile.own) v.new_frame[tile.first + s] = frames[s];
    }
    team.sync();
    own.previous.data += tile.first, own.next += tile.first, own.oldest += tile.first;
    own.shape.data += tile.first;
    for (Vec4*& targets : own.targets) targets += tile.first;
    for (int s = team.thread; s < tile.own; s += Team::threads)
      IntegrateKernel<kMask, false>::integrate({own, of_run, end, of_run.step == 0}, s);
  }
};

/// The tiles of all meshes, as TileStep reads them.
template <class Executor>
class Tiles {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  void hold(std::span<const Int4> neighbours) {
    if (held()) return;
    const TileArrays made = make_tiles(neighbours);
    around_.assign(made.around), neighbours_.assign(made.neighbours), tiles_.assign(made.tiles);
    most_frames_ = made.most_frames, most_positions_ = made.most_positions;
  }
  void drop() { tiles_.resize(0), around_.resize(0), neighbours_.resize(0); }
  bool held() const { return tiles_.size() != 0; }
  TilesView view() {
    return {tiles_.data(), around_.data(), neighbours_.data(), static_cast<int>(tiles_.size()),
            most_frames_,  most_positions_};
  }
  /// add(name, arrays...) for each.
  template <class Add>
  void list(Add&& add) const {
    add("tiles", tiles_, around_, neighbours_);
  }

 private:
  Array<Tile> tiles_;
  Array<int> around_;
  Array<PackedNeighbours> neighbours_;
  int most_frames_ = 0, most_positions_ = 0;
};

}  // namespace simplexseg
