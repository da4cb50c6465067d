// SPDX-License-Identifier: Apache-2.0
#include "session/voxel_edit.h"

#include <cstddef>

#include "core/expect.h"

namespace simplexseg {
namespace {

constexpr ParameterInfo kNoSize{"", 0, 0, 0, "", ""};

// clang-format off
const VoxelEditInfo kEdits[] = {
    {VoxelEdit::KeepLargest, "keep_largest", "keep largest part", "Removes all parts but the largest.", false, false,
     kNoSize},
    {VoxelEdit::RemoveSmall, "remove_small", "remove small parts", "Removes the parts with less than a volume.", false,
     false, {"volume", 100, 0.001f, 1e6f, "mm3", "Parts with less volume are removed."}},
    {VoxelEdit::FillHoles, "fill_holes", "fill holes", "Fills the cavities.", false, false, kNoSize},
    {VoxelEdit::Margin, "margin", "move surface", "Moves the surface outwards or inwards by a distance.", false, false,
     {"distance", 2, -50, 50, "mm", "Distance by which the surface moves outwards; below 0: inwards."}},
    {VoxelEdit::Smooth, "smooth", "smooth", "Smooths the surface; thin parts vanish.", false, false,
     {"deviation", 1, 0.1f, 20, "mm", "Standard deviation of the Gaussian that smooths the object."}},
    {VoxelEdit::Add, "add", "add segmentation", "Adds what belongs to another segmentation.", false, true, kNoSize},
    {VoxelEdit::Subtract, "subtract", "subtract segmentation", "Removes what belongs to another segmentation.", false,
     true, kNoSize},
    {VoxelEdit::Intersect, "intersect", "keep common part", "Keeps only what also belongs to another segmentation.",
     false, true, kNoSize},
    {VoxelEdit::SmartPaint, "smart_paint", "smart paint",
     "Sets the voxels under a stroke with the intensities along its path.", true, false, kNoSize},
    {VoxelEdit::Freeze, "freeze", "freeze", "Keeps the part under a stroke as it is, whatever is marked later.", true,
     false, kNoSize},
};
// clang-format on

}  // namespace

std::span<const VoxelEditInfo> voxel_edits() { return kEdits; }

const VoxelEditInfo& info_of(VoxelEdit edit) {
  SIMPLEXSEG_EXPECT(edit != VoxelEdit::None);
  return kEdits[static_cast<std::size_t>(edit) - 1];
}

}  // namespace simplexseg
