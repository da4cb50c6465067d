// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/rtstruct_read.h"

#include <gdcmReader.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "core/error.h"
#include "core/number_text.h"
#include "io/dicom/dicom.h"
#include "io/dicom/dicom_codes.h"
#include "io/dicom/dicom_requests.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_texts.h"
#include "io/dicom/dicom_validation.h"
#include "io/dicom/dicom_values.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxLabel = 65535;

/// Reads the number of a region; 0 if it has none.
double stated_number(const gdcm::DataSet& item, DicomTag tag) { return integer_of(item, tag).value_or(0); }

bool is_label(double number) { return number >= 1 && number <= kMaxLabel; }

/// Gives the regions whose numbers cannot be labels the smallest free numbers, with a warning.
void renumber(std::vector<StructureRegion>& regions, const std::map<double, std::size_t>& places) {
  int free = 1;
  for (const auto& [number, place] : places) {
    if (is_label(number)) continue;
    while (places.contains(free)) ++free;
    StructureRegion& region = regions[place];
    region.name.value = free++;
    region.warnings.push_back("the region '" + one_line(region.name.name, 60) + "' has the number " +
                              exact_text(number) + ", which cannot be a label: it becomes label " +
                              std::to_string(region.name.value));
  }
}

/// Reads the names of the regions into `regions`. Returns the index of each region by its number in the file.
std::map<double, std::size_t> read_names(const gdcm::DataSet& data, std::vector<StructureRegion>& regions) {
  const std::string coding = text_of(data, {0x0008, 0x0005});
  std::map<double, std::size_t> places;
  each_item(data, {0x3006, 0x0020}, [&](const gdcm::DataSet& item) {
    const double number = stated_number(item, {0x3006, 0x0022});
    const std::string name = utf8_of(raw_text_of(item, {0x3006, 0x0026}), coding);
    if (const auto [place, added] = places.emplace(number, regions.size()); !added) {
      StructureRegion& first = regions[place->second];
      first.warnings.push_back("the regions '" + one_line(first.name.name, 60) + "' and '" + one_line(name, 60) +
                               "' have one number: their contours become one label");
      return;
    }
    StructureRegion& region = regions.emplace_back();
    region.name.name = name;
    region.frame_of_reference = raw_text_of(item, {0x3006, 0x0024});
    if (is_label(number)) region.name.value = static_cast<int>(number);
  });
  renumber(regions, places);
  return places;
}

void read_contour(const gdcm::DataSet& contour, StructureRegion& region) {
  const std::string type = text_of(contour, {0x3006, 0x0042});
  std::vector<double> points = numbers_of(contour, {0x3006, 0x0050});
  const bool closed = type.starts_with("CLOSED_PLANAR") || type.starts_with("CLOSEDPLANAR");
  if (closed && points.size() % 3 != 0)
    throw std::runtime_error("a contour of '" + one_line(region.name.name) + "' has a point without three coordinates");
  if (!closed || points.size() < 9) {
    ++region.other_contours;
    return;
  }
  region.contours.push_back(std::move(points));
  if (region.slab_mm == 0) region.slab_mm = std::max(0.0, number_of(contour, {0x3006, 0x0044}).value_or(0));
}

std::vector<StructureRegion> regions_of(const gdcm::DataSet& data) {
  std::vector<StructureRegion> regions;
  const std::map<double, std::size_t> places = read_names(data, regions);
  each_item(data, {0x3006, 0x0039}, [&](const gdcm::DataSet& item) {
    const auto found = places.find(stated_number(item, {0x3006, 0x0084}));
    if (found == places.end()) return;
    StructureRegion& region = regions[found->second];
    const std::vector<double> rgb = numbers_of(item, {0x3006, 0x002a});
    const auto part = [](double v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0, 255.0)); };
    if (rgb.size() == 3) region.name.colour = Colour{part(rgb[0]), part(rgb[1]), part(rgb[2])};
    each_item(item, {0x3006, 0x0040}, [&](const gdcm::DataSet& contour) { read_contour(contour, region); });
  });
  const std::string coding = text_of(data, {0x0008, 0x0005});
  each_item(data, {0x3006, 0x0080}, [&](const gdcm::DataSet& observation) {
    const auto found = places.find(stated_number(observation, {0x3006, 0x0084}));
    if (found == places.end()) return;
    SegmentCode& code = regions[found->second].name.code;
    if (code.empty()) code = read_segment_code(observation, {0x3006, 0x0086}, coding);
  });
  return regions;
}

}  // namespace

bool is_structure_set(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error)) return false;
  try {
    return has_dicom_preamble(path) && sop_class_name(path).starts_with("RT Structure Set");
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception&) {
    return false;  // the volume reader reports the reason
  }
}

std::vector<StructureRegion> in_reader::read_structure_regions(const fs::path& path) {
  gdcm::Reader reader;
  reader.SetFileName(path.c_str());
  if (!reader.Read()) throw std::runtime_error("it is damaged");
  return regions_of(reader.GetFile().GetDataSet());
}

std::vector<StructureRegion> read_structure_regions(const fs::path& path) {
  require_file(path);
  try {
    if (const std::string damage = damage_of_header(path); !damage.empty()) throw std::runtime_error(damage);
    return request_result(kStructureRegions, path, limits_for_file(path));
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read the contours of " + quoted(path), message_of(exception), "copy or export the file again");
  }
}

}  // namespace simplexseg
