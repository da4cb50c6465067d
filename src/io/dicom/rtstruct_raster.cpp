// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/rtstruct_raster.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/error.h"
#include "core/number_text.h"
#include "io/dicom/dicom_position.h"
#include "io/dicom/plane_positions.h"
#include "io/platform/files.h"
#include "mesh/plane_section.h"

namespace simplexseg {
namespace {

constexpr double kMaxOffPlane = 0.45;  ///< largest distance of a contour point from its plane, in slabs or slices
constexpr double kMaxGap = 1.5;        ///< largest gap between planes without a missing plane, in plane distances
constexpr double kSamePoint = 1e-3;    ///< largest difference between the coordinates of equal points, voxels

/// Contour in voxel coordinates.
struct Outline {
  Polygon polygon;
  double slice = 0;                   ///< mean coordinate along the slices
  double low = 1e300, high = -1e300;  ///< bounds of that coordinate
};

bool same(const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return (a - b).cwiseAbs().maxCoeff() <= kSamePoint; }

/// Removes repeated points, among them a last point that repeats the first.
Polygon without_repeats(const Polygon& polygon) {
  Polygon points;
  for (const Eigen::Vector2d& p : polygon)
    if (points.empty() || !same(points.back(), p)) points.push_back(p);
  while (points.size() > 1 && same(points.front(), points.back())) points.pop_back();
  return points;
}

/// Returns true when the polygons have the same corners in the same or opposite order, from any first corner. Neither
/// has repeated points.
bool are_equal(const Polygon& a, const Polygon& b) {
  const std::size_t count = a.size();
  if (b.size() != count) return false;
  for (std::size_t start = 0; start < count; ++start) {
    if (!same(a[0], b[start])) continue;
    bool forwards = true, backwards = true;
    for (std::size_t c = 1; c < count && (forwards || backwards); ++c) {
      forwards = forwards && same(a[c], b[(start + c) % count]);
      backwards = backwards && same(a[c], b[(start + count - c) % count]);
    }
    if (forwards || backwards) return true;
  }
  return false;
}

/// Toggles the voxels of a slice whose centres are inside the polygon (even-odd rule). The polygon is in voxel
/// coordinates.
void toggle_inside(const Polygon& polygon, int columns, int rows, std::vector<std::uint8_t>& slice) {
  double min_y = polygon[0].y(), max_y = min_y;
  for (const Eigen::Vector2d& p : polygon) min_y = std::min(min_y, p.y()), max_y = std::max(max_y, p.y());
  const int first = std::max(0, static_cast<int>(std::ceil(std::max(min_y, -1.0)))),
            last = std::min(rows - 1, static_cast<int>(std::floor(std::min(max_y, static_cast<double>(rows)))));
  std::vector<double> crossings;
  for (int j = first; j <= last; ++j) {
    crossings.clear();
    for (std::size_t c = 0; c < polygon.size(); ++c) {
      const Eigen::Vector2d &a = polygon[c], &b = polygon[(c + 1) % polygon.size()];
      if ((a.y() <= j) == (b.y() <= j)) continue;
      crossings.push_back(a.x() + (j - a.y()) / (b.y() - a.y()) * (b.x() - a.x()));
    }
    std::sort(crossings.begin(), crossings.end());
    for (std::size_t c = 0; c + 1 < crossings.size(); c += 2) {
      const double begin = std::ceil(std::clamp(crossings[c], 0.0, double(columns))),
                   end = std::ceil(std::clamp(crossings[c + 1], 0.0, double(columns)));
      for (int i = static_cast<int>(begin); i < static_cast<int>(end); ++i)
        slice[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(i)] ^= 1;
    }
  }
}

/// Returns the index of the plane whose slab contains slice `k`; nullopt when none does. `distance`: thickness of a
/// slab; `tolerance`: rounding of positions. Slabs contain their lower side, so that n slabs of one slice are n slices.
std::optional<std::size_t> plane_at(double k, const std::vector<double>& planes, double distance, double tolerance) {
  const auto above = std::lower_bound(planes.begin(), planes.end(), k);
  const double to_above = above == planes.end() ? 1e300 : *above - k;
  const double to_below = above == planes.begin() ? 1e300 : k - *(above - 1);
  const bool is_above = to_above <= to_below + tolerance;
  const auto plane = static_cast<std::size_t>(above - planes.begin()) - (is_above ? 0 : 1);
  if (to_above + to_below <= kMaxGap * distance) return plane;
  const bool inside = is_above ? to_above <= distance / 2 + tolerance : to_below < distance / 2 - tolerance;
  return inside ? std::optional(plane) : std::nullopt;
}

class Rasteriser {
 public:
  Rasteriser(const VolumeGeometry& grid, std::string name, std::span<const StructureRegion> all)
      : index_(grid.index_from_world()), size_(grid.size), name_(std::move(name)), all_(all) {
    result_.labels = Volume(grid, VoxelType::UInt16);
    slice_mm_ = 1 / index_.linear().row(2).norm();
  }

  void add(const StructureRegion& region) {
    if (region.name.value < 1 || region.name.value > 65535)
      fail("a region has the number " + std::to_string(region.name.value) + " instead of 1 to 65535");
    result_.warnings.insert(result_.warnings.end(), region.warnings.begin(), region.warnings.end());
    other_contours_ += region.other_contours;
    const std::vector<Outline> outlines = outlines_of(region);
    const double tolerance = tolerance_of(region);
    const PlanePositions planes = planes_of(positions_of(outlines), tolerance);
    const double distance = distance_of(region, planes);
    for (const Outline& one : outlines) {
      const double limit = kMaxOffPlane * std::max(1.0, distance);
      if (one.slice - one.low > limit || one.high - one.slice > limit)
        fail("contours of '" + one_line(region.name.name) + "' cross slices of the image");
    }
    std::vector<std::vector<Polygon>> polygons(planes.planes.size());
    for (std::size_t c = 0; c < outlines.size(); ++c) {
      Polygon polygon = without_repeats(outlines[c].polygon);
      std::vector<Polygon>& in_plane = polygons[planes.plane_of[c]];
      if (std::any_of(in_plane.begin(), in_plane.end(), [&](const Polygon& p) { return are_equal(p, polygon); }))
        ++repeated_;
      else
        in_plane.push_back(std::move(polygon));
    }
    draw(region, polygons, slices_of(planes.planes, distance, tolerance, polygons));
  }

  StructureLabels finish() && {
    if (result_.segments.empty()) fail("no closed contour lies within the image");
    const auto warn = [&](std::size_t count, const char* one, const char* many) {
      if (count > 0) result_.warnings.push_back(counted(static_cast<std::int64_t>(count), one, many));
    };
    warn(outside_, "contour outside the image is skipped", "contours outside the image are skipped");
    warn(between_, "contour lies between slices of the image: each slice has the contours of the nearest plane",
         "contours lie between slices of the image: each slice has the contours of the nearest plane");
    warn(repeated_, "contour occurs twice and is used once", "contours occur twice and are used once");
    warn(other_contours_, "contour is skipped because it is a point or an open line",
         "contours are skipped because they are points or open lines");
    warn(overlapping_, "voxel belongs to several regions and is assigned to the first",
         "voxels belong to several regions and are assigned to the first");
    if (empty_ > 0)
      result_.warnings.push_back(std::to_string(empty_) + (empty_ == 1 ? " slice" : " slices") +
                                 " between the first and the last " + (empty_ == 1 ? "has" : "have") +
                                 " no contour and stay" + (empty_ == 1 ? "s" : "") + " unlabelled");
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw Error("cannot read the contours of " + name_, why, "choose the structure set of this image");
  }

  std::vector<Outline> outlines_of(const StructureRegion& region) const {
    std::vector<Outline> outlines;
    for (const std::vector<double>& contour : region.contours) {
      Outline& one = outlines.emplace_back();
      for (std::size_t p = 0; p + 2 < contour.size(); p += 3) {
        const Eigen::Vector3d at = index_ * Eigen::Vector3d(contour[p], contour[p + 1], contour[p + 2]);
        one.polygon.emplace_back(at.x(), at.y());
        one.slice += at.z(), one.low = std::min(one.low, at.z()), one.high = std::max(one.high, at.z());
      }
      one.slice /= double(one.polygon.size());
    }
    return outlines;
  }
  static std::vector<double> positions_of(const std::vector<Outline>& outlines) {
    std::vector<double> positions;
    positions.reserve(outlines.size());
    for (const Outline& one : outlines) positions.push_back(one.slice);
    return positions;
  }

  /// Returns the largest distance between contours of one plane, in slices.
  double tolerance_of(const StructureRegion& region) const {
    double coordinate = 0;
    for (const std::vector<double>& contour : region.contours)
      for (const double part : contour) coordinate = std::max(coordinate, std::abs(part));
    return same_position_mm(slice_mm_, coordinate) / slice_mm_;
  }

  /// Returns the thickness of the slabs of a region, in slices.
  double distance_of(const StructureRegion& region, const PlanePositions& planes) {
    const double own = planes.distance();
    if (planes.planes.size() > 2) return own;
    const double expected = region.slab_mm > 0 ? region.slab_mm / slice_mm_ : common_distance();
    return planes.planes.size() == 2 ? std::min(own, expected) : expected;
  }
  /// Returns the median distance of the planes of all regions, in slices; 1 if no region has two planes.
  double common_distance() {
    if (common_distance_) return *common_distance_;
    std::vector<double> gaps;
    for (const StructureRegion& region : all_) {
      const PlanePositions planes = planes_of(positions_of(outlines_of(region)), tolerance_of(region));
      for (std::size_t p = 1; p < planes.planes.size(); ++p) gaps.push_back(planes.planes[p] - planes.planes[p - 1]);
    }
    return *(common_distance_ = gaps.empty() ? 1 : lower_median(std::move(gaps)));
  }

  /// Returns the index of the plane for each slice; -1 for slices without contours.
  std::vector<int> slices_of(const std::vector<double>& planes, double distance, double tolerance,
                             const std::vector<std::vector<Polygon>>& polygons) {
    const auto count = static_cast<std::size_t>(size_[2]);
    std::vector<int> slices(count, -1);
    std::vector<bool> used(planes.size());
    for (std::size_t k = 0; k < count; ++k) {
      if (const auto plane = plane_at(double(k), planes, distance, tolerance); plane && !planes.empty())
        slices[k] = static_cast<int>(*plane), used[*plane] = true;
    }
    const bool any = std::find(used.begin(), used.end(), true) != used.end();
    for (std::size_t p = 0; p < planes.size(); ++p) {
      const double nearest = std::round(planes[p]);
      const bool within = nearest >= 0 && nearest < double(count);
      if (!any && within) slices[static_cast<std::size_t>(nearest)] = static_cast<int>(p), used[p] = true;
      if (!used[p]) (within ? between_ : outside_) += polygons[p].size();
    }
    int since = -1;  // empty slices since the last slice with contours; -1 before the first
    for (const int plane : slices) {
      if (plane >= 0 && since > 0) empty_ += since;
      if (plane >= 0 || since >= 0) since = plane >= 0 ? 0 : since + 1;
    }
    return slices;
  }

  void draw(const StructureRegion& region, const std::vector<std::vector<Polygon>>& polygons,
            const std::vector<int>& slices) {
    const std::size_t count = static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
    std::vector<std::uint8_t> inside(count);
    int drawn = -1;  // plane in `inside`
    for (std::size_t k = 0; k < slices.size(); ++k) {
      if (slices[k] < 0) continue;
      if (slices[k] != drawn) {
        drawn = slices[k];
        std::fill(inside.begin(), inside.end(), std::uint8_t{0});
        for (const Polygon& polygon : polygons[static_cast<std::size_t>(drawn)])
          toggle_inside(polygon, size_[0], size_[1], inside);
      }
      std::uint16_t* const to = result_.labels.voxels<std::uint16_t>().data() + k * count;
      for (std::size_t v = 0; v < count; ++v) {
        if (!inside[v]) continue;
        overlapping_ += to[v] != 0;
        if (to[v] == 0) to[v] = static_cast<std::uint16_t>(region.name.value);
      }
    }
    if (drawn >= 0) result_.segments.push_back(region.name);
  }

  Eigen::Affine3d index_;
  std::array<int, 3> size_;
  std::string name_;
  std::span<const StructureRegion> all_;
  double slice_mm_ = 1;  ///< distance of the slices along their normal
  std::optional<double> common_distance_;
  StructureLabels result_;
  std::size_t outside_ = 0, between_ = 0, repeated_ = 0, other_contours_ = 0, overlapping_ = 0;
  int empty_ = 0;
};

}  // namespace

StructureLabels rasterise_regions(std::span<const StructureRegion> regions, const VolumeGeometry& grid,
                                  const std::filesystem::path& path, std::span<const StructureRegion> all) {
  Rasteriser rasteriser(grid, quoted(path), all.empty() ? regions : all);
  for (const StructureRegion& region : regions) rasteriser.add(region);
  return std::move(rasteriser).finish();
}

StructureLabels read_structure_set(const std::filesystem::path& path, const VolumeGeometry& grid) {
  return rasterise_regions(read_structure_regions(path), grid, path);
}

}  // namespace simplexseg
