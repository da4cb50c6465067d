// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <span>
#include <vector>

#include "gui/look/slice_geometry.h"
#include "image/paint_stroke.h"
#include "session/scene.h"

namespace simplexseg {

/// Borders of the painted, erased and frozen texels of a slice, as segments in mm: start, end, start, end ...
struct PaintOutline {
  std::vector<Eigen::Vector3f> painted, erased, frozen;
};
/// Outline of paint. `strokes`: later ones replace earlier ones; `frozen`: frozen parts; `spacing_mm`: distance between
/// slices.
PaintOutline outline_of(std::span<const PaintStroke> strokes, std::span<const PaintStroke> frozen,
                        const SliceGrid& slice, double spacing_mm);

/// Outline of the paint of the visible meshes of a scene in a slice.
class PaintLayer {
 public:
  /// Computed again only if paint or slice have changed.
  const PaintOutline& in_slice(const Scene& scene, const SliceGrid& slice, double spacing_mm);

 private:
  struct MeshPaint {
    std::vector<PaintStroke> strokes, frozen;
    bool operator==(const MeshPaint&) const = default;
  };
  std::vector<MeshPaint> paint_;  ///< of each visible mesh
  SliceGrid slice_;
  PaintOutline outline_;
};

}  // namespace simplexseg
