// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/rtstruct_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "core/error.h"
#include "io/dicom/plane_positions.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

constexpr double kMinRounding = 1e-4;      ///< distance within a plane, as fraction of the size of the largest contour
constexpr double kMaxRounding = 5e-3;      ///< upper limit of that distance
constexpr double kMaxParallelSine = 1e-3;  ///< largest sine of the angle between normals of parallel planes
constexpr double kMaxUnevenness = 0.1;     ///< largest deviation from even spacing, as fraction of the slice distance
constexpr double kVoxelsAcross = 100;      ///< pixels along the larger in-plane extent of the regions
constexpr double kMaxSlices = 2000;
constexpr double kMaxVoxels = 5e7;

Eigen::Vector3d corner(const std::vector<double>& contour, std::size_t c) {
  return {contour[3 * c], contour[3 * c + 1], contour[3 * c + 2]};
}

/// Returns twice the vector area of a contour, mm^2.
Eigen::Vector3d area_of(const std::vector<double>& contour) {
  const std::size_t count = contour.size() / 3;
  const Eigen::Vector3d first = corner(contour, 0);
  Eigen::Vector3d area(0, 0, 0);
  for (std::size_t c = 1; c + 1 < count; ++c)
    area += (corner(contour, c) - first).cross(corner(contour, c + 1) - first);
  return area;
}

template <class F>
void each_contour(std::span<const StructureRegion> regions, F&& f) {
  for (const StructureRegion& region : regions)
    for (const std::vector<double>& contour : region.contours) f(contour);
}

class GridOfRegions {
 public:
  explicit GridOfRegions(const std::filesystem::path& path) : path_(path) {}

  VolumeGeometry grid(std::span<const StructureRegion> regions, std::span<const StructureRegion> all) const {
    const Eigen::Matrix3d axes = axes_of(regions);
    const std::vector<double> planes = planes_along(axes, regions);
    const std::vector<double> known = planes.size() > 1 ? planes : planes_along(axes, all);
    require_parallel(regions, axes, known);
    VolumeGeometry grid;
    grid.direction = axes;
    const double slice_distance =
        planes.size() == 1 && slab_of(regions) > 0 ? slab_of(regions) : distance_of(planes, known);
    Eigen::AlignedBox3d box;  // bounds of the regions in the coordinates of the grid axes, mm
    each_contour(regions, [&](const std::vector<double>& contour) {
      for (std::size_t c = 0; c < contour.size() / 3; ++c) box.extend(axes.transpose() * corner(contour, c));
    });
    const double extent = std::max(box.sizes()[0], box.sizes()[1]);
    const double slices = std::round((planes.back() - planes.front()) / slice_distance) + 3;
    const double across = std::max(std::clamp(extent / kVoxelsAcross, slice_distance / 4, slice_distance),
                                   std::sqrt(box.sizes()[0] * box.sizes()[1] * slices / kMaxVoxels));
    grid.spacing_mm = {across, across, slice_distance};
    const Eigen::Vector3d first(box.min()[0] - across, box.min()[1] - across, planes.front() - slice_distance);
    grid.origin_mm = axes * first;
    for (int a = 0; a < 2; ++a)
      grid.size[static_cast<std::size_t>(a)] = static_cast<int>(std::ceil(box.sizes()[a] / across)) + 3;
    grid.size[2] = static_cast<int>(slices);
    grid.validate("cannot convert the contours of " + quoted(path_) + " to labels");
    return grid;
  }

 private:
  [[noreturn]] void fail(const std::string& why, const std::string& what_to_do) const {
    throw Error("cannot convert the contours of " + quoted(path_) + " to labels", why, what_to_do);
  }

  /// Returns the unit axes of the grid as columns; the third is the normal of all contours.
  Eigen::Matrix3d axes_of(std::span<const StructureRegion> regions) const {
    Eigen::Vector3d largest(0, 0, 0);
    each_contour(regions, [&](const std::vector<double>& contour) {
      const Eigen::Vector3d area = area_of(contour);
      if (area.norm() > largest.norm()) largest = area;
    });
    if (!(largest.norm() > 0) || !largest.allFinite()) fail("no closed contour is selected", "choose another region");
    Eigen::Vector3d normal = largest.normalized();
    Eigen::Index main = 0;
    normal.cwiseAbs().maxCoeff(&main);
    if (normal[main] < 0) normal = -normal;
    Eigen::Matrix3d axes;
    const Eigen::Vector3d across = main == 0 ? Eigen::Vector3d::UnitY() : Eigen::Vector3d::UnitX();
    axes.col(0) = (across - normal * normal.dot(across)).normalized();
    axes.col(1) = normal.cross(axes.col(0));
    axes.col(2) = normal;
    return axes;
  }

  /// Throws Error when a contour deviates from the normal by more than rounding and by more than a small part of the
  /// distance between `planes`.
  void require_parallel(std::span<const StructureRegion> regions, const Eigen::Matrix3d& axes,
                        const std::vector<double>& planes) const {
    const double distance = std::max(PlanePositions{planes, {}}.distance(), slab_of(regions));
    each_contour(regions, [&](const std::vector<double>& contour) {
      const Eigen::Vector3d area = area_of(contour);
      const double size = std::sqrt(area.norm()), sine = area.normalized().cross(axes.col(2)).norm();
      if (sine > kMaxParallelSine && sine * size > kMaxUnevenness * distance)
        fail("their planes are not parallel", "draw the contours on parallel slices");
    });
  }

  /// Returns the sorted positions of the contours' planes along the normal, mm.
  static std::vector<double> planes_along(const Eigen::Matrix3d& axes, std::span<const StructureRegion> regions) {
    std::vector<double> positions;
    double noise = 0, largest = 0;
    each_contour(regions, [&](const std::vector<double>& contour) {
      double sum = 0, low = 1e300, high = -1e300;
      for (std::size_t c = 0; c < contour.size() / 3; ++c) {
        const double along = axes.col(2).dot(corner(contour, c));
        sum += along, low = std::min(low, along), high = std::max(high, along);
      }
      positions.push_back(sum / (static_cast<double>(contour.size()) / 3));
      const double size = std::sqrt(area_of(contour).norm());
      largest = std::max(largest, size);
      noise = std::max(noise, std::min(high - low, kMaxParallelSine * size));
    });
    const double tolerance =
        plane_tolerance(positions, std::max(noise, kMinRounding * largest), kMaxRounding * largest);
    return planes_of(positions, tolerance).planes;
  }

  /// Returns the stated thickness of the contours, mm; 0 if there is none.
  static double slab_of(std::span<const StructureRegion> regions) {
    double slab = 0;
    for (const StructureRegion& region : regions) slab = std::max(slab, region.slab_mm);
    return slab;
  }

  /// Returns the slice distance at which all `planes` are slices, mm; slices without contours are possible. `known`:
  /// planes from which the distance is estimated.
  double distance_of(const std::vector<double>& planes, const std::vector<double>& known) const {
    double min_gap = 0;
    for (std::size_t p = 1; p < known.size(); ++p) {
      const double gap = known[p] - known[p - 1];
      if (min_gap == 0 || gap < min_gap) min_gap = gap;
    }
    if (min_gap == 0) fail("they lie in a single plane of unknown thickness", "use them together with their image");
    const double extent = planes.back() - planes.front();
    const double slices = std::round(extent / min_gap);
    if (!(slices <= kMaxSlices)) fail("their planes are too close to each other", "export the contours again");
    const double slice_distance = slices > 0 ? extent / slices : min_gap;
    for (const double plane : planes) {
      const double place = (plane - planes.front()) / slice_distance;
      if (std::abs(place - std::round(place)) > kMaxUnevenness)
        fail("their planes are unevenly spaced", "draw the contours on evenly spaced slices");
    }
    return slice_distance;
  }

  const std::filesystem::path& path_;
};

}  // namespace

VolumeGeometry grid_of_regions(std::span<const StructureRegion> regions, std::span<const StructureRegion> all,
                               const std::filesystem::path& path) {
  return GridOfRegions(path).grid(regions, all);
}

}  // namespace simplexseg
