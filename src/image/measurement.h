// SPDX-License-Identifier: Apache-2.0
// Distances, angles and regions of interest that a user draws in an image.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

enum class MeasurementKind : std::uint8_t { Ruler, Angle, Ellipse };

/// Measurement in an image. Its values follow from its points and the image; they are not stored.
struct Measurement {
  std::uint32_t id = 0;
  MeasurementKind kind = MeasurementKind::Ruler;
  /// Positions in mm, LPS. Ruler: the two ends. Angle: end of a leg, vertex, end of the other leg. Ellipse: centre, and
  /// one end of each of two perpendicular semi-axes.
  std::vector<Eigen::Vector3d> points_mm;
  std::string name;
  bool operator==(const Measurement&) const = default;
};

/// Name of a kind in files: "ruler", "angle" or "ellipse".
const char* name_of(MeasurementKind kind);
/// Kind with a name; nullopt for an unknown name.
std::optional<MeasurementKind> find_measurement_kind(const std::string& name);
/// Number of points of a kind: 2 or 3.
std::size_t point_count(MeasurementKind kind);
/// Reason why points do not define a measurement of a kind; nullopt if they do: the number of points is right, all are
/// finite within 1e9 mm, a ruler and the legs of an angle have a length, and the semi-axes of an ellipse have a length
/// and are perpendicular (within 1e-6 rad).
std::optional<std::string> defect_of(MeasurementKind kind, const std::vector<Eigen::Vector3d>& points_mm);

// The functions below need points without a defect.

/// Length of a ruler, mm.
double ruler_length_mm(const Measurement& ruler);
/// Angle between the legs of an angle, 0 to 180 degrees.
double angle_degrees(const Measurement& angle);
/// Area of an ellipse, mm2.
double ellipse_area_mm2(const Measurement& ellipse);

/// Intensities of the voxels in an ellipse; `deviation` is the population standard deviation.
struct EllipseIntensities {
  std::size_t voxels;
  double mean, deviation, minimum, maximum;
};
/// Statistics of the finite voxels in an ellipse; nullopt without one. A voxel belongs to the ellipse if the plane of
/// the ellipse cuts the voxel and its centre, projected onto the plane, lies within the ellipse or on its border. In a
/// slice of the image, these are the voxels of that slice whose centres lie in the ellipse. A plane between two slices
/// cuts the one in the direction of its normal, first semi-axis x second semi-axis.
std::optional<EllipseIntensities> ellipse_intensities(const Measurement& ellipse, const Volume& volume);

/// Values of a measurement; only those of its kind are set.
struct MeasurementValues {
  std::optional<double> length_mm, angle_degrees, area_mm2;
  std::optional<EllipseIntensities> intensities;
};
/// All values of a measurement in a volume, which may be empty.
MeasurementValues values_of(const Measurement& measurement, const Volume& volume);
/// Length with two decimals below 10 mm and one above; with another unit below 1 mm (length_text()).
std::string measured_length_text(double mm);
/// Values as lines of text for the user, in UTF-8: "12.3 mm"; "45.2°"; "123.4 mm²", "40.1 ± 12.3 HU", "-20 to 96 HU",
/// "123 voxels". `unit`: unit of the intensities, or "".
std::vector<std::string> lines_of(const MeasurementValues& values, const std::string& unit);

}  // namespace simplexseg
