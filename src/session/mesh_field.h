// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "field/marks.h"
#include "field/range_effect.h"
#include "image/cell_grid.h"
#include "image/intensity_range.h"
#include "image/paint_stroke.h"

namespace simplexseg {

/// Foreground probability of a mesh's object in a box of voxels, and the marks from which it was solved. Immutable, so
/// that snapshots of a scene can share it.
struct MeshField {
  CellSize cell = kVoxelCells;
  VoxelBox box{};  ///< box of cells of the volume
  /// One value for each cell, encoded as in FieldBox (src/forces/step_view.h); empty if the solution failed.
  std::vector<std::uint16_t> values;
  std::vector<Mark> marks;           ///< empty for a preliminary field
  std::vector<Mark> others;          ///< inside marks of other meshes that reach the box: background for this mesh
  IntensityRange intensity_range{};  ///< with which it was solved (MeshItem::intensity_range)
  std::string model{};               ///< MeshItem::prior_identity() with which it was solved; "": none
  float model_trust = 0;             ///< share of this prior in the field, 0 to 1; 0: it has no effect
  std::uint64_t images = 0;          ///< digest_of() the images in which it was solved
  std::string filters{};             ///< filters of the volume with which it was solved (key_of())
  RangeEffect range_effect = RangeEffect::Limits;
  bool leaks = false;       ///< whether the object reaches the sides of the largest box: it spreads without a border
  float expected_dice = 1;  ///< expected Dice coefficient (EvidenceField::Report); 1 for field_of_start()
  std::string problem;      ///< reason for the failure; empty: none
  /// Field with paint (painted_field()): the field without it, the strokes, and the cells that they cover completely.
  std::shared_ptr<const MeshField> solved{};
  std::vector<PaintStroke> paint{};
  std::vector<std::uint32_t> painted_cells{};

  /// Whether it was solved in a box that may still grow, and another field of the same update follows.
  bool is_preliminary() const { return marks.empty(); }
  /// Whether the segmentation is probably wrong: the expected Dice coefficient is below 0.67, for example because the
  /// seed lies in no object. Measured: true for none of 51 seeds in objects and for all four seeds in bowel
  /// (docs/results/archive/evidence-2026-11-23.md).
  bool probably_wrong() const { return expected_dice < 0.67f; }
  /// Whether the user must be warned about the field.
  bool needs_warning() const {
    return leaks || probably_wrong() || range_effect != RangeEffect::Limits || !problem.empty();
  }

  /// Object mask of the box: 1 for cells inside the object, else 0.
  std::vector<std::uint8_t> object_cells() const;
  /// Object mask on the grid of the volume.
  Mask object(const VolumeGeometry& volume) const;
  /// Grid of the cells of the box.
  VolumeGeometry grid(const VolumeGeometry& volume) const;
};

/// Marks at the time when the user cancelled the update of a field.
struct CancelledUpdate {
  std::vector<Mark> marks;
  std::vector<Mark> others;  ///< inside marks of other meshes that reach the box of the field; empty without a field

  bool operator==(const CancelledUpdate&) const = default;
};

}  // namespace simplexseg
