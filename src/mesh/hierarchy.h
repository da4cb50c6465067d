// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Coarser and coarser graphs of a mesh for the multigrid correction (docs/mathematics.md, section 3): vertices are put
/// together with their neighbours, about four at first and six later, until one is left of each connected part. Needs
/// the connectivity alone, so that any mesh has one.
struct Hierarchy {
  struct Edge {
    int to;             ///< on the same level
    float conductance;  ///< symmetric; 1/3 between neighbours of the mesh itself
  };
  /// A level coarser than the mesh.
  struct Level {
    std::vector<int> part_first, parts;  ///< the vertices of the finer level that each vertex stands for
    std::vector<int> edge_first;         ///< where the edges of each vertex begin
    std::vector<Edge> edges;
    int size() const { return static_cast<int>(part_first.size()) - 1; }
  };
  std::vector<Level> levels;  ///< from fine to coarse
};

/// Deterministic; linear in the number of vertices.
Hierarchy make_hierarchy(std::span<const std::array<int, 3>> neighbours);

}  // namespace simplexseg
