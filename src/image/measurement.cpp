// SPDX-License-Identifier: Apache-2.0
#include "image/measurement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/expect.h"
#include "core/number_text.h"

namespace simplexseg {
namespace {

constexpr std::array<const char*, 3> kKindNames = {"ruler", "angle", "ellipse"};  // in the order of MeasurementKind
constexpr double kCentreTolerance = 1e-9;  // relative tolerance of the tests of voxel centres

/// Angle between two vectors, 0 to pi; accurate for small angles too.
double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// Tests of voxels against an ellipse, in index coordinates.
struct IndexEllipse {
  IndexEllipse(const Measurement& ellipse, const VolumeGeometry& geometry) {
    const Eigen::Affine3d world_from_index = geometry.world_from_index();
    const Eigen::Vector3d a = ellipse.points_mm[1] - ellipse.points_mm[0],
                          b = ellipse.points_mm[2] - ellipse.points_mm[0];
    const Eigen::Vector3d normal = a.cross(b).normalized();
    const Eigen::Matrix3d edges = world_from_index.linear();
    const double half_mm = 0.5 * (edges.transpose() * normal).cwiseAbs().sum();  // half extent of a voxel
    across = edges.transpose() * normal / half_mm;
    along_a = edges.transpose() * a / a.squaredNorm(), along_b = edges.transpose() * b / b.squaredNorm();
    centre = geometry.index_from_world() * ellipse.points_mm[0];
    const Eigen::Matrix3d index_from_mm = geometry.index_from_world().linear();
    const Eigen::Vector3d ia = index_from_mm * a, ib = index_from_mm * b, in = index_from_mm * normal;
    reach = (ia.cwiseAbs2() + ib.cwiseAbs2()).cwiseSqrt() + half_mm * in.cwiseAbs();
  }
  bool contains(const Eigen::Vector3d& index) const {
    const Eigen::Vector3d offset = index - centre;
    const double height = across.dot(offset);
    if (!(height > -1 + kCentreTolerance && height <= 1 + kCentreTolerance)) return false;
    const double u = along_a.dot(offset), v = along_b.dot(offset);
    return u * u + v * v <= 1 + kCentreTolerance;
  }

  Eigen::Vector3d centre, reach;     ///< half extents of the box around the voxels
  Eigen::Vector3d across;            ///< height above the plane, in half extents of a voxel
  Eigen::Vector3d along_a, along_b;  ///< coordinates in units of the semi-axes
};

/// First and last integer in [low, high] and in [0, size - 1]; empty if last < first.
std::pair<int, int> integers_in(double low, double high, int size) {
  const double last = size - 1.0;
  return {static_cast<int>(std::ceil(std::clamp(low, 0.0, last + 1))),
          static_cast<int>(std::floor(std::clamp(high, -1.0, last)))};
}

}  // namespace

const char* name_of(MeasurementKind kind) { return kKindNames.at(static_cast<std::size_t>(kind)); }

std::optional<MeasurementKind> find_measurement_kind(const std::string& name) {
  const auto found = std::find(kKindNames.begin(), kKindNames.end(), name);
  if (found == kKindNames.end()) return std::nullopt;
  return static_cast<MeasurementKind>(found - kKindNames.begin());
}

std::size_t point_count(MeasurementKind kind) { return kind == MeasurementKind::Ruler ? 2 : 3; }

std::optional<std::string> defect_of(MeasurementKind kind, const std::vector<Eigen::Vector3d>& points_mm) {
  constexpr double kFarthestMm = 1e9, kShortestMm = 1e-9, kRightAngle = 1e-6;
  if (points_mm.size() != point_count(kind))
    return "it has " + std::to_string(points_mm.size()) + " points instead of " + std::to_string(point_count(kind));
  for (const Eigen::Vector3d& p : points_mm)
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > kFarthestMm)
      return "a position is not a finite number within 1e9 mm";
  const std::size_t origin = kind == MeasurementKind::Angle ? 1 : 0;
  for (std::size_t p = 0; p < points_mm.size(); ++p)
    if (p != origin && (points_mm[p] - points_mm[origin]).norm() < kShortestMm) return "two of its points coincide";
  if (kind != MeasurementKind::Ellipse) return std::nullopt;
  const Eigen::Vector3d a = points_mm[1] - points_mm[0], b = points_mm[2] - points_mm[0];
  if (std::abs(a.dot(b)) > kRightAngle * a.norm() * b.norm()) return "its semi-axes are not perpendicular";
  return std::nullopt;
}

double ruler_length_mm(const Measurement& ruler) {
  SIMPLEXSEG_EXPECT(ruler.kind == MeasurementKind::Ruler && ruler.points_mm.size() == 2);
  return (ruler.points_mm[1] - ruler.points_mm[0]).norm();
}

double angle_degrees(const Measurement& angle) {
  SIMPLEXSEG_EXPECT(angle.kind == MeasurementKind::Angle && angle.points_mm.size() == 3);
  return 180 / std::numbers::pi *
         angle_between(angle.points_mm[0] - angle.points_mm[1], angle.points_mm[2] - angle.points_mm[1]);
}

double ellipse_area_mm2(const Measurement& ellipse) {
  SIMPLEXSEG_EXPECT(ellipse.kind == MeasurementKind::Ellipse && ellipse.points_mm.size() == 3);
  return std::numbers::pi * (ellipse.points_mm[1] - ellipse.points_mm[0]).norm() *
         (ellipse.points_mm[2] - ellipse.points_mm[0]).norm();
}

std::optional<EllipseIntensities> ellipse_intensities(const Measurement& ellipse, const Volume& volume) {
  SIMPLEXSEG_EXPECT(ellipse.kind == MeasurementKind::Ellipse && ellipse.points_mm.size() == 3);
  if (volume.empty()) return std::nullopt;
  const IndexEllipse test(ellipse, volume.geometry());
  const std::array<int, 3>& size = volume.geometry().size;
  const Eigen::Vector3d low = test.centre - test.reach, high = test.centre + test.reach;
  EllipseIntensities result{0, 0, 0, std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  double squares = 0;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    const auto [first_k, last_k] = integers_in(low[2] - 1e-6, high[2] + 1e-6, size[2]);
    const auto [first_j, last_j] = integers_in(low[1] - 1e-6, high[1] + 1e-6, size[1]);
    for (int k = first_k; k <= last_k; ++k) {
      for (int j = first_j; j <= last_j; ++j) {
        // Part of the row near the plane: an oblique ellipse has few voxels in its box.
        double row_low = low[0] - 1e-6, row_high = high[0] + 1e-6;
        if (const double slope = test.across[0]; std::abs(slope) > 1e-6) {
          const double rest = test.across[1] * (j - test.centre[1]) + test.across[2] * (k - test.centre[2]);
          const auto [from, to] = std::minmax({(-1 - rest) / slope, (1 - rest) / slope});
          row_low = std::max(row_low, test.centre[0] + from - 1),
          row_high = std::min(row_high, test.centre[0] + to + 1);
        }
        const auto [first_i, last_i] = integers_in(row_low, row_high, size[0]);
        for (int i = first_i; i <= last_i; ++i) {
          if (!test.contains(Eigen::Vector3d(i, j, k))) continue;
          const double value = static_cast<double>(voxels[volume.offset(i, j, k)]);
          if (!std::isfinite(value)) continue;
          const double deviation = value - result.mean;
          result.mean += deviation / static_cast<double>(++result.voxels);
          squares += deviation * (value - result.mean);
          result.minimum = std::min(result.minimum, value), result.maximum = std::max(result.maximum, value);
        }
      }
    }
  });
  if (result.voxels == 0) return std::nullopt;
  result.deviation = std::sqrt(squares / static_cast<double>(result.voxels));
  return result;
}

MeasurementValues values_of(const Measurement& measurement, const Volume& volume) {
  switch (measurement.kind) {
    case MeasurementKind::Ruler:
      return {ruler_length_mm(measurement), {}, {}, {}};
    case MeasurementKind::Angle:
      return {{}, angle_degrees(measurement), {}, {}};
    case MeasurementKind::Ellipse:
      break;
  }
  return {{}, {}, ellipse_area_mm2(measurement), ellipse_intensities(measurement, volume)};
}

std::string measured_length_text(double mm) {
  return mm >= 10 ? fixed_text(mm, 1) + " mm" : mm >= 1 ? fixed_text(mm, 2) + " mm" : length_text(mm);
}

std::vector<std::string> lines_of(const MeasurementValues& values, const std::string& unit) {
  std::vector<std::string> lines;
  if (values.length_mm) lines.push_back(measured_length_text(*values.length_mm));
  if (values.angle_degrees) lines.push_back(fixed_text(*values.angle_degrees, 1) + "\u00b0");
  if (values.area_mm2) {
    constexpr double kWhole = 1000;  // from here on without decimals
    const double area = *values.area_mm2;
    lines.push_back((area < kWhole ? general_text(area, 4) : fixed_text(area, 0)) + " mm\u00b2");
  }
  if (const auto& found = values.intensities) {
    const std::string with_unit = unit.empty() ? "" : " " + unit;
    const double scale = std::max(std::abs(found->mean), found->deviation);
    const auto number = [scale](double value) {
      constexpr double kLargest = 1e6;  // a longer number would be hard to read
      return scale >= 1 && scale < kLargest ? fixed_text(value, scale < 10 ? 2 : 1) : general_text(value, 4);
    };
    lines.push_back(number(found->mean) + " \u00b1 " + number(found->deviation) + with_unit);
    lines.push_back(general_text(found->minimum, 4) + " to " + general_text(found->maximum, 4) + with_unit);
    lines.push_back(counted(static_cast<std::int64_t>(found->voxels), "voxel"));
  } else if (values.area_mm2) {
    lines.emplace_back("no voxel");
  }
  return lines;
}

}  // namespace simplexseg
