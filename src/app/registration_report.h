// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

#include "image/transform.h"
#include "io/registration/registration.h"
#include "io/transform/landmarks.h"

namespace simplexseg {

/// Result of a registration with what a user needs to judge it.
struct RegistrationReport {
  std::string fixed, moving;  ///< paths of the images
  RegistrationResult result;
  JacobianRange jacobian;                  ///< over the grid of the fixed image
  std::vector<double> landmark_residuals;  ///< distance of each mapped landmark from its counterpart, mm
  double seconds = 0;                      ///< time of the registration, without reading and writing
};

/// Checksum of a transform, 16 hexadecimal digits: equal for equal bits of matrices and vectors.
std::string checksum_of(const Transform& transform);

/// Writes the report as JSON. Throws Error for a failed write or a path that is not UTF-8.
void write_report(const std::filesystem::path& path, const RegistrationReport& report);
/// Prints the report as text.
void print_report(std::ostream& out, const RegistrationReport& report);

}  // namespace simplexseg
