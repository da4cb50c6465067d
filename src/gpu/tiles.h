// SPDX-License-Identifier: Apache-2.0
// Tiles of consecutive vertices, each with a halo of the other vertices that a step of the tile reads. With tiles a
// device computes a step in one launch: each block computes the frames of its tile and of two rings around it in shared
// memory (docs/adr/0035-single-launch-step.md).
#pragma once
#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "gpu/kernels.h"

namespace simplexseg {

/// Vertices that a step of one tile reads, numbered as slots: first the vertices of the tile, then rings 1 and 2 around
/// the tile, whose frames the forces read, then ring 3, whose positions are needed for the frames of ring 2.
struct Tile {
  int first, own;         ///< first vertex of the tile, and number of its vertices
  int frames, positions;  ///< number of slots with a frame; number of all slots
  int halo;               ///< offset of the halo in TilesView::halo
  int neighbours;         ///< offset of slot 0 in TilesView::neighbours
};
struct TilesView {
  const Tile* tiles = nullptr;
  const int* halo = nullptr;                     ///< vertices of the halos of all tiles
  const PackedNeighbours* neighbours = nullptr;  ///< neighbours of all slots with a frame, as differences of slots
  int count = 0, max_frames = 0, max_positions = 0;
};

struct TileArrays {
  std::vector<Tile> tiles;
  std::vector<int> halo;
  std::vector<PackedNeighbours> neighbours;
  int max_frames = 0, max_positions = 0;
};

/// Number of vertices of a tile; the last tile may have fewer.
inline constexpr int kTileVertices = 64;
/// Largest number of active vertices for which tiles are used; with more vertices, two launches are faster.
inline constexpr int kMaxTiledVertices = 50'000;
/// Largest number of vertices, active or not, for which tiles are used.
inline constexpr int kMaxVerticesWithTiles = 500'000;

/// Divides the vertices of all meshes into tiles. Empty if the index of a mesh exceeds 16 bits.
inline TileArrays make_tiles(std::span<const Int4> neighbours) {
  constexpr int kFrameRings = 2;
  TileArrays all;
  const int n = static_cast<int>(neighbours.size());
  std::vector<int> tile_of(n, -1), slot(n);  // latest tile that contains each vertex, and its slot in it
  std::vector<int> vertices;
  for (int first = 0; first < n; first += kTileVertices) {
    const int index = static_cast<int>(all.tiles.size());
    vertices.clear();
    auto add = [&](int i) {
      if (tile_of[i] == index) return;
      tile_of[i] = index, slot[i] = static_cast<int>(vertices.size());
      vertices.push_back(i);
    };
    const int own = std::min(kTileVertices, n - first);
    for (int i = first; i < first + own; ++i) add(i);
    int frames = 0;
    for (int ring = 0, begin = 0; ring <= kFrameRings; ++ring) {
      const int end = static_cast<int>(vertices.size());
      if (ring == kFrameRings) frames = end;
      for (int s = begin; s < end; ++s) {
        const Int4& nb = neighbours[vertices[s]];
        add(nb.x), add(nb.y), add(nb.z);
      }
      begin = end;
    }
    all.tiles.push_back({first, own, frames, static_cast<int>(vertices.size()), static_cast<int>(all.halo.size()),
                         static_cast<int>(all.neighbours.size())});
    for (int s = 0; s < frames; ++s) {
      const Int4& nb = neighbours[vertices[s]];
      if (nb.w > std::numeric_limits<std::uint16_t>::max()) return {};
      auto difference = [&](int j) { return static_cast<std::int16_t>(slot[j] - s); };
      all.neighbours.push_back(
          {difference(nb.x), difference(nb.y), difference(nb.z), static_cast<std::uint16_t>(nb.w)});
    }
    all.halo.insert(all.halo.end(), vertices.begin() + own, vertices.end());
    all.max_frames = std::max(all.max_frames, frames);
    all.max_positions = std::max(all.max_positions, static_cast<int>(vertices.size()));
  }
  return all;
}

/// Step of the vertices of one tile: computes the frames of the tile and its halo, then integrates. Frames are read
/// from one array and written to another, because other tiles may still read the earlier frames. `shared`: shared
/// memory of the block, shared_bytes() bytes. Does not support attraction, whose sums another kernel must compute
/// before.
template <unsigned kMask>
struct TileStep {
  static constexpr const char *name = IntegrateKernel<kMask, false>::name, *fused_name = GeometryKernel::name;
  static constexpr int kThreads = 128;
  StepView v;
  TilesView tiles;
  StepInRun run_step;
  End end;
  std::size_t shared_bytes() const {
    return (tiles.max_positions + tiles.max_frames) * sizeof(Vec4) + tiles.max_positions * sizeof(int);
  }
  template <class Block>
  SIMPLEXSEG_HD void operator()(int index, Block block, Vec4* shared) const {
    const Tile tile = tiles.tiles[index];
    Vec4 *positions = shared, *frames = shared + tiles.max_positions;
    int* vertices = reinterpret_cast<int*>(frames + tiles.max_frames);  // vertex of each slot
    const PackedNeighbours* neighbours = tiles.neighbours + tile.neighbours;
    // These reads do not depend on earlier kernels, which may still be running.
    for (int s = block.thread; s < tile.positions; s += Block::threads)
      vertices[s] = s < tile.own ? tile.first + s : tiles.halo[tile.halo + s - tile.own];
    block.wait_for_earlier_kernels();
    for (int s = block.thread; s < tile.positions; s += Block::threads) positions[s] = v.current[vertices[s]];
    if (index == 0 && block.thread == 0) run_step.count(v.status);
    block.sync();
    StepView own = v;  // indexed by slots
    own.first_vertex = tile.first;
    own.current = {positions}, own.frame = {frames}, own.new_frame = frames;
    own.neighbours = {nullptr, neighbours};
    for (int s = block.thread; s < tile.frames; s += Block::threads) {
      GeometryKernel::compute_frame(own, s, [&](int) { return xyz(v.frame[vertices[s]]); });
      if (s < tile.own) v.new_frame[tile.first + s] = frames[s];
    }
    block.sync();
    own.previous.data += tile.first, own.next += tile.first, own.oldest += tile.first;
    own.shape.data += tile.first;
    for (Vec4*& targets : own.targets) targets += tile.first;
    for (int s = block.thread; s < tile.own; s += Block::threads)
      IntegrateKernel<kMask, false>::integrate({own, run_step, end, run_step.step == 0}, s);
  }
};

/// Arrays of the tiles of all meshes.
template <class Executor>
class Tiles {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  void allocate(std::span<const Int4> neighbours) {
    if (allocated()) return;
    const TileArrays made = make_tiles(neighbours);
    halo_.assign(made.halo), neighbours_.assign(made.neighbours), tiles_.assign(made.tiles);
    max_frames_ = made.max_frames, max_positions_ = made.max_positions;
  }
  void release() { tiles_.resize(0), halo_.resize(0), neighbours_.resize(0); }
  bool allocated() const { return tiles_.size() != 0; }
  TilesView view() {
    return {tiles_.data(), halo_.data(),  neighbours_.data(), static_cast<int>(tiles_.size()),
            max_frames_,   max_positions_};
  }
  /// Calls add(name, arrays...) for each group of arrays.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("tiles", tiles_, halo_, neighbours_);
  }

 private:
  Array<Tile> tiles_;
  Array<int> halo_;
  Array<PackedNeighbours> neighbours_;
  int max_frames_ = 0, max_positions_ = 0;
};

}  // namespace simplexseg
