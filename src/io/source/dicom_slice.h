// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cstddef>
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
  std::size_t start = 0;  ///< offset of the pixel data in the file, bytes
};

/// Header data of one frame of a DICOM image: image plane (PS3.3 C.7.6.2) and functional groups (C.7.6.16).
struct DicomSlice {
  std::filesystem::path file;
  int frame = 0;                        ///< index of the frame in the file, from 0
  std::string sop_class, sop_instance;  ///< UIDs of the file
  std::string series, description, modality;
  DicomPixels pixels;
  std::optional<Eigen::Vector3d> position;          ///< centre of the first pixel, LPS, mm
  std::optional<Eigen::Matrix<double, 3, 2>> axes;  ///< unit vectors along i (column index) and j (row index)
  std::optional<Eigen::Vector2d> spacing_mm;        ///< pixel spacing along i and j
  std::optional<double> slice_distance_mm, thickness_mm;
  double slope = 1, intercept = 0;  ///< rescaling: value = slope * stored + intercept
  /// Attributes that can distinguish the volumes of a series, with their values, e.g. ("echo time", "20").
  std::vector<std::pair<std::string, std::string>> traits;
  std::string segmentation;                                  ///< BINARY, FRACTIONAL or LABELMAP; empty for images
  int segment = 0;                                           ///< segment number of the frame, from 1; 0: none
  std::shared_ptr<const std::vector<SegmentName>> segments;  ///< segments of a segmentation
  bool may_overlap = true;                                   ///< segments may overlap (Segments Overlap, (0062,0013))
  int fraction_max = 1;                            ///< stored value of a voxel that a fractional segment fills
  std::string photometric;                         ///< photometric interpretation, e.g. MONOCHROME2
  std::string assumed;                             ///< warning about an assumed position; empty when none
  std::string unreadable;                          ///< reason why the pixels cannot be read; empty when they can
  std::string remedy = "copy or export it again";  ///< remedy if the pixels cannot be read
};

}  // namespace simplexseg
