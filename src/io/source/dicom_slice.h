// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/source/segment_names.h"

namespace simplexseg {

/// Encoding of the pixels of a DICOM image (PS3.3 C.7.6.3). `samples`: samples per pixel; `bits`: bits allocated per
/// sample.
struct DicomPixels {
  int rows = 0, columns = 0, frames = 1, samples = 1;
  int bits = 0, stored_bits = 0, high_bit = 0;
  bool is_signed = false;
  bool plain = false;  ///< pixel data is neither compressed nor deflated
  bool big_endian = false;
  /// Pixels of at most 8 bits are stored in big-endian words (OW), so that the bytes of each word are swapped (PS3.5
  /// A.3).
  bool in_words = false;
  std::size_t start = 0;  ///< offset of the pixel data in the file, bytes
};

/// Header data of one frame of a DICOM image: image plane (PS3.3 C.7.6.2) and functional groups (C.7.6.16).
struct DicomSlice {
  std::filesystem::path file;
  int frame = 0;                        ///< index of the frame in the file, from 0
  std::string sop_class, sop_instance;  ///< UIDs of the file
  std::string series, description, modality;
  std::string frame_of_reference;  ///< UID; empty if the file states none
  DicomPixels pixels;
  std::optional<Eigen::Vector3d> position;          ///< centre of the first pixel, LPS, mm
  std::optional<Eigen::Matrix<double, 3, 2>> axes;  ///< unit vectors along i (column index) and j (row index)
  std::optional<Eigen::Vector2d> spacing_mm;        ///< pixel spacing along i and j
  std::optional<double> slice_distance_mm;          ///< magnitude of Spacing Between Slices, (0018,0088)
  /// Spacing Between Slices is negative: in nuclear medicine, slices are stacked against the normal (PS3.3 C.8.4.15).
  bool stacked_backwards = false;
  std::optional<double> thickness_mm;
  std::optional<double> instance_number;
  double slope = 1, intercept = 0;  ///< rescaling: value = slope * stored + intercept
  /// Modality LUT (PS3.3 C.11.1), which replaces the rescaling; null if there is none. Stored values up to
  /// `lut_begin` have its first value, stored values beyond its end the last.
  std::shared_ptr<const std::vector<std::uint16_t>> modality_lut;
  int lut_begin = 0;
  /// Attributes that can distinguish the volumes of a series, with their values, e.g. ("echo time", "20").
  std::vector<std::pair<std::string, std::string>> traits;
  std::string segmentation;                                  ///< BINARY, FRACTIONAL or LABELMAP; empty for images
  int segment = 0;                                           ///< segment number of the frame, from 1; 0: none
  std::shared_ptr<const std::vector<SegmentName>> segments;  ///< segments of a segmentation
  int background = 0;                                        ///< value of a label map outside all segments
  int fraction_max = 1;                            ///< stored value of a voxel that a fractional segment fills
  std::string photometric;                         ///< photometric interpretation, e.g. MONOCHROME2
  std::string assumed;                             ///< warning about an assumed position; empty when none
  std::string ignored;                             ///< warning about elements without effect; empty when none
  std::string unreadable;                          ///< reason why the pixels cannot be read; empty when they can
  std::string remedy = "copy or export it again";  ///< remedy if the pixels cannot be read
};

}  // namespace simplexseg
