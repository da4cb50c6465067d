// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Levels of the multigrid correction of a mesh (docs/mathematics.md, section 3). Each level aggregates the vertices of
/// the finer one with their neighbours, about four on the first level and six later, down to one vertex for each
/// connected component. Depends only on the connectivity and exists for every mesh.
struct Hierarchy {
  struct Edge {
    int to;             ///< vertex of the same level
    float conductance;  ///< symmetric; 1/3 between neighbours of the mesh itself
  };
  /// A level coarser than the mesh.
  struct Level {
    std::vector<int> part_first, parts;  ///< aggregated vertices of the finer level, in compressed rows
    std::vector<int> edge_first;         ///< first edge of each vertex
    std::vector<Edge> edges;
    int size() const { return static_cast<int>(part_first.size()) - 1; }
  };
  std::vector<Level> levels;  ///< ordered from fine to coarse
};

/// Builds the hierarchy. Deterministic; linear time in the number of vertices.
Hierarchy make_hierarchy(std::span<const std::array<int, 3>> neighbours);

}  // namespace simplexseg
