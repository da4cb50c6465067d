// SPDX-License-Identifier: Apache-2.0
// The header of NIfTI and Analyze files, as numbers.
// Format: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h and nifti2.h.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <string>

#include "image/volume.h"
#include "io/packed_reader.h"
#include "io/stored_voxels.h"
#include "io/volume_io.h"

namespace simplexseg {

/// The fields that are read, in the widest type that any version has them in; names as in the format's description.
struct NiftiHeader {
  std::array<unsigned char, 540> bytes{};  ///< as in the file
  int version = 0;                         ///< 0: Analyze; 1, 2: NIfTI; -1: neither
  bool swapped = false;                    ///< the file is of the other byte order
  bool single_file = false;                ///< the voxels follow in the same file
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int datatype = 0, qform_code = 0, sform_code = 0, units = 0;
  double slope = 0, intercept = 0, vox_offset = 0;
  std::array<double, 3> quaternion{}, qoffset{};
  Eigen::Matrix<double, 3, 4> srow;

  template <class T>
  T at(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  /// Fills the fields of `count` numbers of type T from `offset` on.
  template <class T, class Array>
  void fill(Array& to, std::size_t offset, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) to[i] = at<T>(offset + i * sizeof(T));
  }
};

/// Reads the header from the start of a file; version -1 when it is neither NIfTI nor Analyze.
NiftiHeader read_nifti_header(PackedReader& reader);

/// What a header's `datatype` means. Throws Error, with the file's name, for what is not one number a voxel.
StoredType stored_type(int datatype, const std::string& name);

/// Takes the numbers of voxels, frames and components. Throws Error, with the file's name, where they make no sense.
void set_sizes(const NiftiHeader& header, VolumeInfo& info, const std::string& name);

}  // namespace simplexseg
