// SPDX-License-Identifier: Apache-2.0
// Header fields of NIfTI and Analyze files.
// Format: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h and nifti2.h.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "image/volume.h"
#include "io/platform/decompressing_reader.h"
#include "io/source/stored_voxels.h"
#include "io/source/volume_info.h"

namespace simplexseg {

constexpr int kNiftiLengthUnits = 7;  ///< bits of the field for units that contain the unit of length

/// Header fields, each in the widest type of any version. Most names are those of the format description.
struct NiftiHeader {
  std::array<unsigned char, 540> bytes{};  ///< header as stored
  int version = 0;                         ///< 0: Analyze; 1, 2: NIfTI; -1: neither
  bool swapped = false;                    ///< the byte order of the file differs from the machine's
  bool single_file = false;                ///< the voxels are in the same file
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int datatype = 0, qform_code = 0, sform_code = 0, units = 0;
  double slope = 0, intercept = 0, vox_offset = 0;
  std::array<double, 3> quaternion{}, qoffset{};
  Eigen::Matrix<double, 3, 4> srow;

  /// Number of type T at a byte offset.
  template <class T>
  T at(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  /// Copies `count` numbers of type T, beginning at `offset`, into an array.
  template <class T, class Array>
  void fill(Array& to, std::size_t offset, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) to[i] = at<T>(offset + i * sizeof(T));
  }
};

/// Reads the header at the start of a file; version -1 if it is neither NIfTI nor Analyze.
NiftiHeader read_nifti_header(DecompressingReader& reader);

/// Voxel type of a `datatype` code. Throws Error, with the file `name`, for colours, complex numbers, bits, 128-bit
/// numbers and unknown codes.
StoredType stored_type(int datatype, const std::string& name);

/// Sets the numbers of voxels along the axes, of frames (with their times) and of components. Throws Error, with the
/// file `name`, if the header has an invalid number of dimensions or of voxels along an axis.
void set_sizes(const NiftiHeader& header, VolumeInfo& info, const std::string& name);

}  // namespace simplexseg
