// SPDX-License-Identifier: Apache-2.0
// RT structure sets of squares, built byte by byte.
#pragma once
#include <Eigen/Geometry>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "dicom_files.h"

namespace simplexseg::test {

constexpr int kNumberZero = -1;  ///< stands for the number 0 of a region

/// Squares with half side `half_mm` around a centre, one at each distance `z_mm` from it.
struct Squares {
  std::string name;
  double half_mm;
  std::vector<double> z_mm;
  int number = 0;  ///< number of the region; 0: its place in the list, from 1
  const char* type = "CLOSED_PLANAR";
  std::string frame_of_reference{};  ///< UID; empty: attribute missing
};

/// Positions every 2 mm from -half_mm to half_mm.
inline std::vector<double> positions_every_2_mm(double half_mm) {
  std::vector<double> positions;
  for (double z = -half_mm; z <= half_mm; z += 2) positions.push_back(z);
  return positions;
}

/// Returns the bytes of the file. `place` maps coordinates of the squares to LPS.
inline std::string structure_set_of_squares(const Eigen::Isometry3d& place, const std::vector<Squares>& regions) {
  std::vector<std::string> names, contours;
  for (std::size_t n = 0; n < regions.size(); ++n) {
    const Squares& squares = regions[n];
    std::vector<std::string> slices;
    for (const double z : squares.z_mm) {
      std::vector<double> corners;
      for (const auto& [x, y] : {std::pair(-1, -1), std::pair(1, -1), std::pair(1, 1), std::pair(-1, 1)}) {
        const Eigen::Vector3d corner = place * Eigen::Vector3d(x * squares.half_mm, y * squares.half_mm, z);
        corners.insert(corners.end(), corner.begin(), corner.end());
      }
      DicomData contour;
      contour.text(0x3006, 0x0042, "CS", squares.type).numbers(0x3006, 0x0050, corners);
      slices.push_back(contour.bytes);
    }
    const int stated = squares.number == 0 ? static_cast<int>(n) + 1 : squares.number;
    const std::string number = stated == kNumberZero ? "0" : std::to_string(stated);
    DicomData region, drawn;
    region.text(0x3006, 0x0022, "IS", number);
    if (!squares.frame_of_reference.empty()) region.text(0x3006, 0x0024, "UI", squares.frame_of_reference);
    region.text(0x3006, 0x0026, "LO", squares.name);
    names.push_back(region.bytes);
    contours.push_back(drawn.sequence(0x3006, 0x0040, slices).text(0x3006, 0x0084, "IS", number).bytes);
  }
  DicomData data;
  const char* const kind = "1.2.840.10008.5.1.4.1.1.481.3";
  data.text(0x0008, 0x0016, "UI", kind).text(0x0008, 0x0018, "UI", "1.2.3").text(0x0008, 0x0060, "CS", "RTSTRUCT");
  data.sequence(0x3006, 0x0020, names).sequence(0x3006, 0x0039, contours);
  return dicom_file(data.bytes, kind);
}

}  // namespace simplexseg::test
