// SPDX-License-Identifier: Apache-2.0
#include "peers/boxed_peer.h"

#include <algorithm>
#include <utility>

#include "core/error.h"
#include "field/brush_radius.h"
#include "field/evidence_box.h"
#include "field/evidence_settings.h"

namespace simplexseg {
namespace {

constexpr int kMostGrowths = 12;
constexpr EvidenceSettings kSettings;

/// Extends an object that is cut by the volume to the sides of the volume.
void extend_to_volume_edge(std::vector<float>& field, std::span<const Constraint> known, const BoxGrid& grid) {
  for (int v = 0; v < grid.count(); ++v) {
    if (known[v] != Constraint::VolumeEdge) continue;
    const std::array<int, 3> at{v % grid.row(), v % grid.plane() / grid.row(), v / grid.plane()};
    int inner = v;
    for (int a = 0; a < 3; ++a) {
      if (grid.size[a] < 3) continue;
      if (at[a] == 0) inner += grid.stride(a);
      if (at[a] == grid.size[a] - 1) inner -= grid.stride(a);
    }
    if (known[inner] != Constraint::VolumeEdge) field[v] = field[inner];
  }
}

}  // namespace

BoxedPeer::BoxedPeer(const Volume& image, RunJobs run) : volume_(image), run_(std::move(run)) {}

Mask BoxedPeer::segment(std::span<const Mark> marks) {
  const VolumeGeometry& geometry = volume_.geometry();
  if (std::none_of(marks.begin(), marks.end(), [](const Mark& m) { return m.kind == MarkKind::Inside; }))
    throw Error("marks", "there is no inside mark", "begin with a seed");
  box_ = box_around_marks(marks, geometry, kSettings.margin_share, kSettings.least_margin);
  const Eigen::Vector3d spacing = geometry.spacing_mm / geometry.spacing_mm.minCoeff();
  Mask object{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  for (int growths = 0;; ++growths) {
    const BoxImage image = extract_box(volume_, kVoxelCells, box_, run_);
    known_ = constraint_mask(geometry, box_, image.finite, marks, {});
    std::vector<std::uint8_t> before(box_.voxel_count());
    for (int k = 0; k < box_.size[2]; ++k)
      for (int j = 0; j < box_.size[1]; ++j)
        std::copy_n(object.voxels.data() + volume_.offset(box_.first[0], box_.first[1] + j, box_.first[2] + k),
                    box_.size[0], before.data() + box_.offset(0, j, k));
    std::vector<float> field = solve({image, spacing, known_, before});
    extend_to_volume_edge(field, known_, image.grid);
    for (std::size_t v = 0; v < field.size(); ++v)
      if (known_[v] == Constraint::Inside || known_[v] == Constraint::Outside)
        field[v] = known_[v] == Constraint::Inside;
    object_ = object_of_field(field, known_, box_);
    object = mask_of(geometry, box_, object_.voxels);
    if (growths == kMostGrowths || object_.bounds.voxel_count() == 0) return object;
    const VoxelBox grown = grow_around(box_, object_.bounds, geometry);
    if (grown == box_) return object;
    box_ = grown;
  }
}

double BoxedPeer::brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const {
  return brush_radius_mm(volume_.geometry(), box_, object_.voxels, known_, kind, mm);
}

}  // namespace simplexseg
