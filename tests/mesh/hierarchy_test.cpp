// SPDX-License-Identifier: Apache-2.0
#include "mesh/hierarchy.h"

#include <gtest/gtest.h>

#include <map>

#include "mesh/simplex_mesh.h"

namespace simplexseg {
namespace {

TEST(Hierarchy, EveryVertexHasOneCoarseVertexDownToASingleOne) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10, 4);
  const Hierarchy h = make_hierarchy(mesh.neighbours);
  ASSERT_FALSE(h.levels.empty());
  int finer = mesh.vertex_count();
  for (const Hierarchy::Level& level : h.levels) {
    std::vector<int> seen(finer, 0);
    for (int p : level.parts) ++seen.at(p);
    EXPECT_EQ(seen, std::vector<int>(finer, 1));
    EXPECT_EQ(level.part_first.back(), finer);
    EXPECT_LE(2 * level.size(), finer);
    finer = level.size();
  }
  EXPECT_EQ(finer, 1);
  EXPECT_LT(h.levels.front().size(), 0.27 * mesh.vertex_count());
  EXPECT_LE(h.levels.size(), 7u);
}

TEST(Hierarchy, EdgesAreSymmetric) {
  const Hierarchy h = make_hierarchy(make_sphere({0, 0, 0}, 10, 3).neighbours);
  for (const Hierarchy::Level& level : h.levels) {
    std::map<std::pair<int, int>, float> edges;
    for (int i = 0; i < level.size(); ++i)
      for (int e = level.edge_first[i]; e < level.edge_first[i + 1]; ++e) {
        EXPECT_NE(level.edges[e].to, i);
        EXPECT_TRUE(edges.emplace(std::pair(i, level.edges[e].to), level.edges[e].conductance).second) << "twice";
      }
    for (const auto& [ends, conductance] : edges) {
      ASSERT_TRUE(edges.contains({ends.second, ends.first}));
      EXPECT_NEAR(edges.at({ends.second, ends.first}), conductance, 1e-5 * conductance);
    }
  }
}

TEST(Hierarchy, SeparatePartsStaySeparate) {
  const SimplexMesh small = make_sphere({0, 0, 0}, 1, 1), large = make_sphere({0, 0, 0}, 1, 3);
  auto neighbours = small.neighbours;
  const int offset = small.vertex_count();
  for (auto nb : large.neighbours) neighbours.push_back({nb[0] + offset, nb[1] + offset, nb[2] + offset});
  const Hierarchy h = make_hierarchy(neighbours);
  EXPECT_EQ(h.levels.back().size(), 2);
  EXPECT_TRUE(h.levels.back().edges.empty());
  EXPECT_TRUE(make_hierarchy({}).levels.empty());
}

}  // namespace
}  // namespace simplexseg
