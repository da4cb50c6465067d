// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom_colour.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace simplexseg {
namespace {

constexpr double kKnee = 6.0 / 29;                // value of the CIELab function below which the function is linear
const Eigen::Vector3d kWhite(0.9642, 1, 0.8251);  // X, Y, Z of white point D50

Eigen::Matrix3d rgb_from_xyz() {
  Eigen::Matrix3d matrix;  // XYZ with white point D50 to linear sRGB, Bradford adaptation
  matrix << 3.1338561, -1.6168667, -0.4906146, -0.9787684, 1.9161415, 0.0334540, 0.0719453, -0.2289914, 1.4052427;
  return matrix;
}

}  // namespace

Colour colour_of_lab(const DicomLab& lab) {
  const double l = lab[0] / 65535.0 * 100, a = lab[1] / 65535.0 * 255 - 128, b = lab[2] / 65535.0 * 255 - 128;
  const double fy = (l + 16) / 116;
  const auto linear = [](double f) { return f > kKnee ? f * f * f : 3 * kKnee * kKnee * (f - 4.0 / 29); };
  const Eigen::Vector3d xyz(linear(fy + a / 500), linear(fy), linear(fy - b / 200));
  const Eigen::Vector3d rgb = rgb_from_xyz() * xyz.cwiseProduct(kWhite);
  const auto byte = [](double v) {
    const double shown = v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(shown, 0.0, 1.0)));
  };
  return {byte(rgb[0]), byte(rgb[1]), byte(rgb[2])};
}

DicomLab lab_of_colour(const Colour& colour) {
  const auto light = [](std::uint8_t byte) {
    const double shown = byte / 255.0;
    return shown <= 0.04045 ? shown / 12.92 : std::pow((shown + 0.055) / 1.055, 2.4);
  };
  const Eigen::Vector3d rgb(light(colour.red), light(colour.green), light(colour.blue));
  const Eigen::Vector3d xyz = (rgb_from_xyz().inverse() * rgb).cwiseQuotient(kWhite);
  const auto f = [](double t) { return t > kKnee * kKnee * kKnee ? std::cbrt(t) : t / (3 * kKnee * kKnee) + 4.0 / 29; };
  const double fx = f(xyz[0]), fy = f(xyz[1]), fz = f(xyz[2]);
  const auto part = [](double share) {
    return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0, 1.0)));
  };
  return {part((116 * fy - 16) / 100), part((500 * (fx - fy) + 128) / 255), part((200 * (fy - fz) + 128) / 255)};
}

}  // namespace simplexseg
