// SPDX-License-Identifier: Apache-2.0
// Tiles for a step in one launch. backends_test.cpp and the tests of the reference model compare the results of such
// steps with those of the CPU.
#include "gpu/tiles.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "gpu/vertex_order.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

/// Neighbours of two meshes in the order of an engine.
std::vector<Int4> neighbours_of_two_meshes() {
  std::vector<Int4> neighbours;
  for (int k = 0; k < 2; ++k) {
    const SimplexMesh mesh = make_sphere({40.0 * k, 1, 2}, 15, k == 0 ? 3 : 2);
    const std::vector<int> order = patch_order(mesh.neighbours);
    std::vector<int> place(order.size());
    const int first = static_cast<int>(neighbours.size());
    for (std::size_t to = 0; to < order.size(); ++to) place[order[to]] = first + static_cast<int>(to);
    for (int i : order) {
      const auto& nb = mesh.neighbours[i];
      neighbours.push_back({place[nb[0]], place[nb[1]], place[nb[2]], k});
    }
  }
  return neighbours;
}

TEST(TilesTest, EachVertexIsInOneTileWithItsNeighbours) {
  const std::vector<Int4> neighbours = neighbours_of_two_meshes();
  const TileArrays all = make_tiles(neighbours);
  std::set<int> seen;
  for (const Tile& tile : all.tiles) {
    auto vertex_of = [&](int slot) {
      return slot < tile.own ? tile.first + slot : all.halo[tile.halo + slot - tile.own];
    };
    for (int s = 0; s < tile.own; ++s) EXPECT_TRUE(seen.insert(vertex_of(s)).second);
    std::set<int> framed, read;
    for (int s = 0; s < tile.positions; ++s) read.insert(vertex_of(s));
    EXPECT_EQ(static_cast<int>(read.size()), tile.positions) << "a vertex has two slots";
    for (int s = 0; s < tile.frames; ++s) {
      framed.insert(vertex_of(s));
      const Int4& nb = neighbours[vertex_of(s)];
      const PackedNeighbours& packed = all.neighbours[tile.neighbours + s];
      EXPECT_EQ(vertex_of(s + packed.x), nb.x);
      EXPECT_EQ(vertex_of(s + packed.y), nb.y);
      EXPECT_EQ(vertex_of(s + packed.z), nb.z);
      EXPECT_EQ(packed.mesh, nb.w);
    }
    for (int s = 0; s < tile.own; ++s)
      for (int a : {neighbours[vertex_of(s)].x, neighbours[vertex_of(s)].y, neighbours[vertex_of(s)].z}) {
        const Int4& b = neighbours[a];
        for (int ring : {a, b.x, b.y, b.z}) EXPECT_TRUE(framed.contains(ring));
      }
  }
  EXPECT_EQ(seen.size(), neighbours.size());
  EXPECT_GT(all.tiles.size(), 10u);
}

TEST(TilesTest, NoTilesForMoreMeshesThan16Bits) {
  std::vector<Int4> neighbours = neighbours_of_two_meshes();
  neighbours[5].w = 65536;
  EXPECT_TRUE(make_tiles(neighbours).tiles.empty());
}

}  // namespace
}  // namespace simplexseg
