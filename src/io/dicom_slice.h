// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace simplexseg {

/// What the header of one DICOM image says. Attributes: DICOM PS3.3, C.7.6.2 (image plane) and C.7.6.3 (pixels).
struct DicomSlice {
  std::filesystem::path file;
  std::string series, description;
  int rows = 0, columns = 0, frames = 1, samples = 1;
  std::optional<Eigen::Vector3d> position;          ///< where the first pixel's centre is, LPS mm
  std::optional<Eigen::Matrix<double, 3, 2>> axes;  ///< directions of the columns (i) and rows (j)
  std::optional<Eigen::Vector2d> spacing_mm;        ///< along i and j
  std::optional<double> between_mm, thickness_mm;
  std::string pixel_kind;  ///< bits, sign and rescaling: equal for slices of one type
  std::string unreadable;  ///< why its pixels cannot be read; empty when they can
};

/// Reads the header; nothing when the file is not DICOM or holds no image. Throws std::exception on a damaged file.
std::optional<DicomSlice> scan_dicom(const std::filesystem::path& path);

/// The name of its file, for messages.
std::string name_of(const DicomSlice& slice);

/// "'a', 'b' and 3 more".
std::string list_of(const std::vector<std::string>& names, std::size_t most = 12);

}  // namespace simplexseg
