// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <span>
#include <vector>

namespace simplexseg {

/// Levels of the multigrid correction of a mesh (docs/mathematics.md, section 3). Each vertex of a level represents an
/// aggregate of neighbouring vertices of the next finer level: about four on the first level and six on later levels.
/// The coarsest level has one vertex for each connected component. Depends only on the connectivity of the mesh.
struct Hierarchy {
  struct Edge {
    int to;             ///< adjacent vertex of the same level
    float conductance;  ///< equal in both directions; 1/3 between neighbours of the mesh
  };
  /// Level that is coarser than the mesh.
  struct Level {
    std::vector<int> part_first, parts;  ///< vertices of the next finer level by aggregate, as compressed rows
    std::vector<int> edge_first;         ///< first edge of each vertex
    std::vector<Edge> edges;
    int size() const { return static_cast<int>(part_first.size()) - 1; }
  };
  std::vector<Level> levels;  ///< ordered from fine to coarse
};

/// Builds the hierarchy of a mesh from the three neighbours of each vertex. Deterministic; takes time linear in the
/// number of vertices.
Hierarchy make_hierarchy(std::span<const std::array<int, 3>> neighbours);

}  // namespace simplexseg
