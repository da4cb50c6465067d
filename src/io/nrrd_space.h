// SPDX-License-Identifier: Apache-2.0
// The frames that NRRD headers name. Format: https://teem.sourceforge.net/nrrd/format.html#space.
#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

namespace simplexseg {

/// The frame of a NRRD file's vectors.
struct NrrdSpace {
  int dimension = 3;                                             ///< 4 with time, which comes last
  Eigen::Matrix3d lps_from_space = Eigen::Matrix3d::Identity();  ///< of the three spatial components
  bool anatomical = true;  ///< false: of the scanner or of nothing, so that the patient's sides are not known
};

/// "left-posterior-superior", "LPS" and so on, in any order of the three axes and in any case, with or without "-time"
/// or "T", "scanner-xyz", "3D-right-handed", "3D-left-handed"; nothing for another name.
std::optional<NrrdSpace> nrrd_space_of(const std::string& name);

/// Millimetres in a unit of length as headers name it ("mm", "cm", "micrometer" ...), 1 where none is named; nothing
/// for what is no length.
std::optional<double> millimetres_of(const std::string& unit);

}  // namespace simplexseg
