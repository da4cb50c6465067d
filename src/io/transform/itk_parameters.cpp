// SPDX-License-Identifier: Apache-2.0
#include "io/transform/itk_parameters.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr const char* kSupported =
    "save it as AffineTransform, Euler3DTransform, VersorRigid3DTransform or Similarity3DTransform of three dimensions";

/// Rotation of a versor, whose fourth component follows from the others.
Eigen::Matrix3d rotation_of_versor(const double* v, const std::string& name) {
  const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
  if (square > 1 + 1e-6) throw Error("cannot read " + name, "its versor is longer than 1", "save the transform again");
  return Eigen::Quaterniond(std::sqrt(std::max(0.0, 1 - square)), v[0], v[1], v[2]).normalized().toRotationMatrix();
}

Eigen::Matrix3d rotation_of_angles(const double* angles, bool zyx) {
  const Eigen::AngleAxisd x(angles[0], Eigen::Vector3d::UnitX()), y(angles[1], Eigen::Vector3d::UnitY()),
      z(angles[2], Eigen::Vector3d::UnitZ());
  return (zyx ? z * y * x : z * x * y).toRotationMatrix();
}

}  // namespace

Eigen::Affine3d affine_of(const ItkParameters& itk, const std::string& name) {
  const std::string kind = itk.type.substr(0, itk.type.find('_'));
  const std::string dimensions = itk.type.size() > kind.size() ? itk.type.substr(kind.size()) : "";
  if (dimensions != "_double_3_3" && dimensions != "_float_3_3")
    throw Error("cannot read " + name, "its transform " + quoted(itk.type) + " does not map three dimensions to three",
                kSupported);
  const auto require = [&](std::size_t parameters, std::size_t fixed) {
    if (itk.parameters.size() != parameters || itk.fixed.size() < fixed)
      throw Error("cannot read " + name,
                  "its " + kind + " has " + counted(static_cast<std::int64_t>(itk.parameters.size()), "parameter") +
                      " and " + counted(static_cast<std::int64_t>(itk.fixed.size()), "fixed parameter"),
                  "save the transform again");
  };
  for (const std::vector<double>* values : {&itk.parameters, &itk.fixed}) {
    if (!std::all_of(values->begin(), values->end(), [](double v) { return std::isfinite(v); }))
      throw Error("cannot read " + name, "a parameter is not finite", "save the transform again");
  }
  const double* const p = itk.parameters.data();
  Eigen::Affine3d affine = Eigen::Affine3d::Identity();
  if (kind == "IdentityTransform") return affine;
  if (kind == "TranslationTransform") {
    require(3, 0);
    affine.translation() = Eigen::Map<const Eigen::Vector3d>(p);
    return affine;
  }
  std::ptrdiff_t shift_at = 3;  // index, since there may be no parameters
  if (kind == "AffineTransform" || kind == "MatrixOffsetTransformBase") {
    require(12, 3);
    affine.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(p);
    shift_at = 9;
  } else if (kind == "Euler3DTransform") {
    require(6, 3);
    affine.linear() = rotation_of_angles(p, itk.fixed.size() > 3 && itk.fixed[3] != 0);
  } else if (kind == "VersorRigid3DTransform") {
    require(6, 3);
    affine.linear() = rotation_of_versor(p, name);
  } else if (kind == "Similarity3DTransform") {
    require(7, 3);
    affine.linear() = p[6] * rotation_of_versor(p, name);
  } else {
    throw Error("cannot read " + name, "transforms of the kind " + quoted(kind) + " are not supported", kSupported);
  }
  const Eigen::Map<const Eigen::Vector3d> centre(itk.fixed.data()), shift(p + shift_at);
  affine.translation() = shift + centre - affine.linear() * centre;
  return affine;
}

ItkParameters affine_parameters(const Eigen::Affine3d& affine) {
  ItkParameters itk{"AffineTransform_double_3_3", {}, {0, 0, 0}};
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) itk.parameters.push_back(affine.linear()(a, b));
  }
  for (int a = 0; a < 3; ++a) itk.parameters.push_back(affine.translation()[a]);
  return itk;
}

}  // namespace simplexseg
