// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/rtstruct_read.h"

#include <gdcmReader.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "core/error.h"
#include "io/dicom/dicom.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_validation.h"
#include "io/dicom/dicom_values.h"
#include "io/platform/files.h"
#include "io/platform/quiet_libraries.h"
#include "mesh/plane_section.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr double kMaxOffPlane = 0.45;  ///< largest distance of a contour point from its slice, in slice distances

std::vector<StructureRegion> regions_of(const gdcm::DataSet& data) {
  std::vector<StructureRegion> regions;
  std::map<int, std::size_t> places;
  each_item(data, {0x3006, 0x0020}, [&](const gdcm::DataSet& item) {
    const int number = static_cast<int>(std::clamp(number_of(item, {0x3006, 0x0022}).value_or(0), 0.0, 1e9));
    if (!places.emplace(number, regions.size()).second) return;
    StructureRegion& region = regions.emplace_back();
    region.name.value = number;
    region.name.name = text_of(item, {0x3006, 0x0026});
    while (region.name.name.ends_with(' ')) region.name.name.pop_back();
  });
  each_item(data, {0x3006, 0x0039}, [&](const gdcm::DataSet& item) {
    const auto found = places.find(static_cast<int>(number_of(item, {0x3006, 0x0084}).value_or(-1)));
    if (found == places.end()) return;
    StructureRegion& region = regions[found->second];
    const std::vector<double> rgb = numbers_of(item, {0x3006, 0x002a});
    const auto part = [](double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0)); };
    if (rgb.size() == 3) region.name.colour = Colour{part(rgb[0]), part(rgb[1]), part(rgb[2])};
    each_item(item, {0x3006, 0x0040}, [&](const gdcm::DataSet& contour) {
      std::vector<double> points = numbers_of(contour, {0x3006, 0x0050});
      if (!text_of(contour, {0x3006, 0x0042}).starts_with("CLOSED_PLANAR"))
        ++region.other_contours;
      else if (points.size() % 3 != 0)
        throw std::runtime_error("a contour of '" + one_line(region.name.name) +
                                 "' has a point without three coordinates");
      else if (points.size() >= 9)
        region.contours.push_back(std::move(points));
    });
  });
  return regions;
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

class Rasteriser {
 public:
  Rasteriser(const VolumeGeometry& grid, std::string name)
      : index_(grid.index_from_world()), size_(grid.size), name_(std::move(name)) {
    result_.labels = Volume(grid, VoxelType::UInt16);
  }

  void add(const StructureRegion& region) {
    if (region.name.value < 1 || region.name.value > 65535)
      fail("a region has the number " + std::to_string(region.name.value) + " instead of 1 to 65535");
    std::map<int, std::vector<Polygon>> by_slice;
    for (const std::vector<double>& contour : region.contours) {
      Polygon polygon;
      double sum = 0, min_z = 1e300, max_z = -1e300;
      for (std::size_t p = 0; p < contour.size(); p += 3) {
        const Eigen::Vector3d at = index_ * Eigen::Vector3d(contour[p], contour[p + 1], contour[p + 2]);
        polygon.emplace_back(at.x(), at.y());
        sum += at.z(), min_z = std::min(min_z, at.z()), max_z = std::max(max_z, at.z());
      }
      const double slice = std::round(sum / double(polygon.size()));
      if (slice - min_z > kMaxOffPlane || max_z - slice > kMaxOffPlane)
        fail("contours of '" + one_line(region.name.name) + "' cross slices of the image");
      if (slice < 0 || slice >= size_[2])
        ++outside_;
      else
        by_slice[static_cast<int>(slice)].push_back(std::move(polygon));
    }
    other_contours_ += region.other_contours;
    const std::size_t count = static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]);
    for (const auto& [k, polygons] : by_slice) {
      std::vector<std::uint8_t> inside(count);
      for (const Polygon& polygon : polygons) toggle_inside(polygon, size_[0], size_[1], inside);
      std::uint16_t* const to = result_.labels.voxels<std::uint16_t>().data() + static_cast<std::size_t>(k) * count;
      for (std::size_t v = 0; v < count; ++v) {
        if (!inside[v]) continue;
        overlapping_ += to[v] != 0;
        if (to[v] == 0) to[v] = static_cast<std::uint16_t>(region.name.value);
      }
    }
    if (!by_slice.empty()) result_.segments.push_back(region.name);
  }

  StructureLabels finish() && {
    if (result_.segments.empty()) fail("no closed contour lies within the image");
    const auto warn = [&](std::size_t count, const char* what) {
      if (count > 0) result_.warnings.push_back(std::to_string(count) + what);
    };
    warn(outside_, " contours outside the image are skipped");
    warn(other_contours_, " contours are skipped because they are points or open lines");
    warn(overlapping_, " voxels belong to several regions and are assigned to the first");
    return std::move(result_);
  }

 private:
  [[noreturn]] void fail(const std::string& why) const {
    throw Error("cannot read the contours of " + name_, why, "choose the structure set of this image");
  }

  Eigen::Affine3d index_;
  std::array<int, 3> size_;
  std::string name_;
  StructureLabels result_;
  std::size_t outside_ = 0, other_contours_ = 0, overlapping_ = 0;
};

}  // namespace

bool is_structure_set(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  const QuietLibraries quiet;
  try {
    return has_dicom_preamble(path) && sop_class_name(path).starts_with("RT Structure Set");
  } catch (const std::exception&) {
    return false;  // the volume reader reports the reason
  }
}

std::vector<StructureRegion> read_structure_regions(const fs::path& path) {
  require_file(path);
  const QuietLibraries quiet;
  std::vector<StructureRegion> regions;
  try {
    if (const std::string damage = damage_of_header(path); !damage.empty()) throw std::runtime_error(damage);
    without_aborting([&] {
      gdcm::Reader reader;
      reader.SetFileName(path.c_str());
      if (!reader.Read()) throw std::runtime_error("it is damaged");
      regions = regions_of(reader.GetFile().GetDataSet());
    });
  } catch (const std::exception& exception) {
    throw Error("cannot read the contours of " + quoted(path), message_of(exception), "copy or export the file again");
  }
  return regions;
}

StructureLabels rasterise_regions(std::span<const StructureRegion> regions, const VolumeGeometry& grid,
                                  const fs::path& path) {
  Rasteriser rasteriser(grid, quoted(path));
  for (const StructureRegion& region : regions) rasteriser.add(region);
  return std::move(rasteriser).finish();
}

StructureLabels read_structure_set(const fs::path& path, const VolumeGeometry& grid) {
  return rasterise_regions(read_structure_regions(path), grid, path);
}

}  // namespace simplexseg
