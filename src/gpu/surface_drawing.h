// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "core/error.h"
#include "gpu/display_kernels.h"
#include "gpu/launcher.h"
#include "image/volume.h"
#include "mesh/simplex_mesh.h"
#include "step/engine.h"

namespace simplexseg {

/// Draws surfaces, outlines and slices of an engine into host buffers or buffers shared with OpenGL.
template <class Executor>
class SurfaceDrawing {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  void clear_cells() {
    has_cells_ = false, cell_count_ = 0;
    place_.resize(0), cell_first_.resize(0), cell_corners_.resize(0), surfaces_.resize(0);
  }
  /// Sets the cells, one list per mesh. `orders`: as MeshArrays::orders(). Throws Error if they do not match the
  /// meshes.
  void set_cells(std::span<const CellList* const> cells, std::span<const MeshConstants> meshes,
                 std::span<const std::vector<int>> orders, int vertex_count) {
    if (cells.size() != meshes.size())
      throw Error("cells", "the number of lists differs from the number of meshes",
                  "pass the cells of the loaded meshes");
    std::vector<int> first{0}, corners, place(vertex_count);
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const MeshConstants& c = meshes[k];
      std::vector<int> inverse(c.vertex_count);
      for (int i = 0; i < c.vertex_count; ++i) inverse[orders[k][i]] = i;
      for (int cell = 0; cell < cells[k]->count(); ++cell) {
        for (int corner : (*cells[k])[cell]) {
          if (corner < 0 || corner >= c.vertex_count)
            throw Error("cells", "a corner is not a vertex of the mesh", "pass the cells of the loaded meshes");
          corners.push_back(c.first_vertex + inverse[corner]);
        }
        first.push_back(static_cast<int>(corners.size()));
      }
      for (int i = 0; i < c.vertex_count; ++i) place[c.first_vertex + i] = c.first_vertex + orders[k][i];
    }
    cell_count_ = static_cast<int>(first.size()) - 1;
    cell_first_.assign(first), cell_corners_.assign(corners), place_.assign(place);
    has_cells_ = true;
  }
  bool has_cells() const { return has_cells_; }

  void draw_surfaces(Launcher<Executor>& launcher, const StepView& view, DrawTarget<DisplayPoint> target) {
    if (!has_cells_) throw Error("surfaces", "their cells have not been set", "call set_cells() after load()");
    const std::size_t n = static_cast<std::size_t>(view.vertex_count) + cell_count_;
    if (n == 0) return;
    launcher.executor.draw(target, n, surfaces_, [&](DisplayPoint* points) {
      launcher.run(DrawVertices{view, place_.data(), points}, view.vertex_count);
      launcher.run(DrawCells{cell_first_.data(), cell_corners_.data(), place_.data(), points, view.vertex_count},
                   cell_count_);
    });
  }
  void draw_outlines(Launcher<Executor>& launcher, const StepView& view, int axis, float position_mm,
                     DrawTarget<std::byte> target) {
    if (!has_cells_) throw Error("outlines", "the cells have not been set", "call set_cells() after load()");
    const std::size_t bytes = outline_bytes(view.mesh_count, view.vertex_count);
    if (bytes == 0) return;
    launcher.executor.draw(target, bytes, outlines_, [&](std::byte* memory) {
      auto* commands = reinterpret_cast<OutlineCommand*>(memory);
      auto* segments = reinterpret_cast<OutlineSegment*>(memory + view.mesh_count * sizeof(OutlineCommand));
      launcher.run(BeginOutlines{view.meshes, commands}, view.mesh_count);
      launcher.run(DrawOutlines{view, cell_first_.data(), cell_corners_.data(), axis, position_mm, commands, segments},
                   cell_count_);
    });
  }
  void draw_slice(Launcher<Executor>& launcher, const VolumeView& volume, VoxelType type, const SlicePlane& plane,
                  DrawTarget<DisplayTexel> target) {
    const std::size_t n = static_cast<std::size_t>(std::max(plane.width, 0)) * std::max(plane.height, 0);
    if (n == 0) return;
    launcher.executor.draw(target, n, slice_, [&](DisplayTexel* texels) {
      launcher.executor.visit_voxels(type, [&]<class Voxels>(std::type_identity<Voxels>) {
        launcher.run(DrawSlice<Voxels>{volume, plane, texels}, static_cast<int>(n));
      });
    });
  }

  /// Calls add(name, array) for each array.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("drawing", place_), add("cells", cell_corners_), add("cell ends", cell_first_);
    add("drawn surfaces", surfaces_), add("drawn slice", slice_), add("drawn outlines", outlines_);
  }

 private:
  Array<int> place_, cell_first_, cell_corners_;
  Array<DisplayPoint> surfaces_;  ///< staging memory for host buffers, as are the next two arrays
  Array<DisplayTexel> slice_;
  Array<std::byte> outlines_;
  bool has_cells_ = false;
  int cell_count_ = 0;
};

}  // namespace simplexseg
