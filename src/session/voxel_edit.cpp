// SPDX-License-Identifier: Apache-2.0
#include "session/voxel_edit.h"

#include <cstddef>

#include "core/expect.h"

namespace simplexseg {
namespace {

constexpr ParameterInfo kNoSize{"", 0, 0, 0, "", ""};

const VoxelEditInfo kEdits[] = {
    {VoxelEdit::KeepLargest, "keep_largest", "keep largest part", false, false, kNoSize},
    {VoxelEdit::RemoveSmall,
     "remove_small",
     "remove small parts",
     false,
     false,
     {"volume", 100, 0.001f, 1e6f, "mm3", "Parts with less volume are removed."}},
    {VoxelEdit::FillHoles, "fill_holes", "fill holes", false, false, kNoSize},
    {VoxelEdit::Margin,
     "margin",
     "margin",
     false,
     false,
     {"distance", 2, -50, 50, "mm", "Distance by which the surface moves outwards; below 0: inwards."}},
    {VoxelEdit::Smooth,
     "smooth",
     "smooth",
     false,
     false,
     {"deviation", 1, 0.1f, 20, "mm", "Standard deviation of the Gaussian that smooths the object."}},
    {VoxelEdit::Add, "add", "add segmentation", false, true, kNoSize},
    {VoxelEdit::Subtract, "subtract", "subtract segmentation", false, true, kNoSize},
    {VoxelEdit::Intersect, "intersect", "intersect segmentations", false, true, kNoSize},
    {VoxelEdit::SmartPaint, "smart_paint", "smart paint", true, false, kNoSize},
    {VoxelEdit::Freeze, "freeze", "freeze", true, false, kNoSize},
};

}  // namespace

std::span<const VoxelEditInfo> voxel_edits() { return kEdits; }

const VoxelEditInfo& info_of(VoxelEdit edit) {
  SIMPLEXSEG_EXPECT(edit != VoxelEdit::None);
  return kEdits[static_cast<std::size_t>(edit) - 1];
}

}  // namespace simplexseg
