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

#include "io/segment_names.h"

namespace simplexseg {

/// How the pixels of a DICOM image are kept: PS3.3 C.7.6.3.
struct DicomPixels {
  int rows = 0, columns = 0, frames = 1, samples = 1;
  int bits = 0, stored_bits = 0, high_bit = 0;
  bool is_signed = false;
  bool plain = false;  ///< neither compressed nor deflated
  bool big_endian = false;
  std::size_t start = 0;  ///< where in the file they begin
};

/// What the header says of one frame of a DICOM image. Attributes: DICOM PS3.3, C.7.6.2 (image plane), C.7.6.16
/// (functional groups of each frame).
struct DicomSlice {
  std::filesystem::path file;
  int frame = 0;                        ///< of the file's, from 0
  std::string sop_class, sop_instance;  ///< of the file
  std::string series, description, modality;
  DicomPixels pixels;
  std::optional<Eigen::Vector3d> position;          ///< where the first pixel's centre is, LPS mm
  std::optional<Eigen::Matrix<double, 3, 2>> axes;  ///< directions of the columns (i) and rows (j)
  std::optional<Eigen::Vector2d> spacing_mm;        ///< along i and j
  std::optional<double> between_mm, thickness_mm;
  double slope = 1, intercept = 0;  ///< value = slope * stored + intercept
  /// By what volumes of one series can differ, and its value here: ("echo time", "20").
  std::vector<std::pair<std::string, std::string>> traits;
  std::string segmentation;                                  ///< BINARY, FRACTIONAL or LABELMAP; empty for images
  int segment = 0;                                           ///< whose frame it is, from 1
  std::shared_ptr<const std::vector<SegmentName>> segments;  ///< of a segmentation
  bool overlap = true;                                       ///< whether its segments may
  int fraction_most = 1;                                     ///< what a voxel has that is whole of a fractional segment
  std::string photometric;                                   ///< MONOCHROME2 ...
  std::string assumed;                             ///< what had to be assumed of its place; empty when nothing had
  std::string unreadable;                          ///< why its pixels cannot be read; empty when they can
  std::string remedy = "copy or export it again";  ///< for that
};

/// Reads the header: one slice for each frame, in the file's order, but a single one where the pixels are unreadable.
/// None when the file is not DICOM or holds no image. Throws std::exception on a damaged file.
std::vector<DicomSlice> scan_dicom(const std::filesystem::path& path);

/// What kind of object a DICOM file without an image is, in DICOM's words; empty where it does not say, or is none.
std::string kind_of_dicom(const std::filesystem::path& path);

/// The name of its file, and of its frame where the file has several, for messages.
std::string name_of(const DicomSlice& slice);

/// "'a', 'b' and 3 more".
std::string list_of(const std::vector<std::string>& names, std::size_t most = 12);

}  // namespace simplexseg
