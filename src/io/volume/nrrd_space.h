// SPDX-License-Identifier: Apache-2.0
// Coordinate systems of NRRD headers. Format: https://teem.sourceforge.net/nrrd/format.html#space.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

namespace simplexseg {

/// Coordinate system of the vectors in a NRRD header.
struct NrrdSpace {
  int dimension = 3;                                             ///< 4 if time is the last component
  Eigen::Matrix3d lps_from_space = Eigen::Matrix3d::Identity();  ///< converts the three spatial components to LPS
  bool anatomical = true;  ///< false: relative to the scanner or undefined, the patient's left is unknown
};

/// Coordinate system with a name: "left-posterior-superior", "LPS" and so on, with the axes in any order, in upper or
/// lower case, with or without "-time" or "T"; or "scanner-xyz", "3D-right-handed", "3D-left-handed". Returns nullopt
/// for other names.
std::optional<NrrdSpace> nrrd_space_of(const std::string& name);

/// Millimetres per unit of length ("mm", "cm", "micrometer" ...); 1 for an empty name, nullopt for an unknown unit.
std::optional<double> millimetres_of(const std::string& unit);

}  // namespace simplexseg
