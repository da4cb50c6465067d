// SPDX-License-Identifier: Apache-2.0
// The hierarchies of all meshes as the arrays that the multigrid kernels read (src/gpu/multigrid.h).
#pragma once
#include <algorithm>
#include <array>
#include <span>
#include <vector>

#include "core/hierarchy.h"
#include "core/step_view.h"

namespace simplexseg {

struct LevelArrays {
  std::vector<CoarseRow> rows;
  std::vector<int> parts, coarse_of;
  std::vector<CoarseEdge> edges;
  std::vector<int> first;          ///< vertex of each coarser level, and the end of the last; counted over all levels
  std::vector<int> roots;          ///< of each mesh: the vertex that stands for all of it
};

/// Level by level, on each of them mesh by mesh.
inline LevelArrays arrange_levels(std::span<const MeshConstants> meshes, std::span<const Int4> neighbours) {
  LevelArrays all;
  std::vector<Hierarchy> hierarchies;
  std::size_t depth = 0;
  for (const MeshConstants& m : meshes) {
    std::vector<std::array<int, 3>> own(m.vertex_count);
    for (int i = 0; i < m.vertex_count; ++i) {
      const Int4 nb = neighbours[m.first_vertex + i];
      own[i] = {nb.x - m.first_vertex, nb.y - m.first_vertex, nb.z - m.first_vertex};
    }
    hierarchies.push_back(make_hierarchy(own));
    depth = std::max(depth, hierarchies.back().levels.size());
    all.roots.push_back(m.first_vertex);
  }
  std::vector<int>& finer = all.roots;          // of each mesh: its first vertex on the level above, at last its root
  int next = static_cast<int>(neighbours.size());
  all.coarse_of.assign(next, 0);
  all.first.assign(1, next);
  for (std::size_t l = 0; l < depth; ++l) {
    for (std::size_t k = 0; k < hierarchies.size(); ++k) {
      if (l >= hierarchies[k].levels.size()) continue;
      const Hierarchy::Level& level = hierarchies[k].levels[l];
      for (int i = 0; i < level.size(); ++i) {
        CoarseRow row{static_cast<int>(all.parts.size()), static_cast<int>(all.edges.size()), 0, static_cast<int>(k)};
        for (int p = level.part_first[i]; p < level.part_first[i + 1]; ++p) {
          all.parts.push_back(finer[k] + level.parts[p]);
          all.coarse_of[all.parts.back()] = next + i;
        }
        for (int e = level.edge_first[i]; e < level.edge_first[i + 1]; ++e) {
          all.edges.push_back({next + level.edges[e].to, level.edges[e].conductance});
          row.degree += level.edges[e].conductance;
        }
        all.rows.push_back(row);
      }
      finer[k] = next;
      next += level.size();
      all.coarse_of.resize(next, 0);
    }
    all.first.push_back(next);
  }
  all.rows.push_back({static_cast<int>(all.parts.size()), static_cast<int>(all.edges.size()), 0, 0});
  if (all.edges.empty()) all.edges.push_back({0, 0});
  return all;
}

}  // namespace simplexseg
