// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace simplexseg {

/// Transform of ITK as its files state it.
struct ItkParameters {
  std::string type;  ///< name of the class with its number type and dimensions, e.g. "AffineTransform_double_3_3"
  std::vector<double> parameters, fixed;
};

/// Affine map of a transform of ITK, whose centre and translation are composed. Throws Error, with the file `name`, for
/// a class that is not supported, another number of parameters, or parameters that are not finite.
Eigen::Affine3d affine_of(const ItkParameters& itk, const std::string& name);

/// Parameters of an AffineTransform with its centre at the origin.
ItkParameters affine_parameters(const Eigen::Affine3d& affine);

}  // namespace simplexseg
