// SPDX-License-Identifier: Apache-2.0
// Geometry as the header of an image's file states it. Labels of the image repeat the statement, so that every program
// that prefers one of several matrices or another convention places both alike.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "image/volume.h"

namespace simplexseg {

/// Geometry fields of a NIfTI header, named as in the format description, in the unit of the file. For Analyze, which
/// has only voxel sizes, both codes are 0.
struct NiftiFrame {
  int version = 1;  ///< 1 or 2: NIfTI-1 with floats, NIfTI-2 with doubles
  int qform_code = 0, sform_code = 0;
  int units = 0;  ///< code of the unit of length: 0 unknown, 1 m, 2 mm, 3 um
  std::array<double, 4> pixdim{};
  std::array<double, 3> quaternion{}, qoffset{};
  std::array<double, 12> srow{};  ///< rows x, y, z of the sform
  bool operator==(const NiftiFrame&) const = default;
};

/// Header lines of a NRRD file that place its three spatial axes, each with its line break.
struct NrrdFrame {
  std::string lines;
};

/// Header lines of a MetaImage file that place its first three axes, each with its line break.
struct MetaImageFrame {
  std::string lines;
};

/// Frame of Reference UID of a DICOM image (PS3.3 C.7.4.1): coordinates correspond only within one frame of reference.
struct DicomFrame {
  std::string frame_of_reference;
};

/// Statement of a grid in a file.
struct StoredHeader {
  VolumeGeometry grid;  ///< grid that the reader derives from the statement
  std::variant<NiftiFrame, NrrdFrame, MetaImageFrame, DicomFrame> frame;
};

/// Adds to a grid, as read from a file, the statement of the file.
template <class Frame>
void keep_header(VolumeGeometry& grid, Frame frame) {
  grid.header.reset();
  grid.header = std::make_shared<const StoredHeader>(StoredHeader{grid, std::move(frame)});
}

/// Statement of a grid in a file of the same format; nullptr when the grid was read from another format or from no
/// file, or was changed since.
template <class Frame>
const Frame* stored_frame(const VolumeGeometry& grid) {
  constexpr double rounding = 1e-6;  // voxels
  if (!grid.header || !grid.header->grid.same_grid(grid, rounding)) return nullptr;
  return std::get_if<Frame>(&grid.header->frame);
}

}  // namespace simplexseg
