// SPDX-License-Identifier: Apache-2.0
#include "io/dicom_write/rtstruct_write.h"

#include <algorithm>
#include <cmath>

#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "mesh/plane_section.h"

namespace simplexseg {
namespace {

constexpr const char* kStructureSet = "1.2.840.10008.5.1.4.1.1.481.3";
constexpr const char* kStudy = "1.2.840.10008.3.1.2.3.1";  // SOP class UID for references to studies
constexpr double kMinStepsPerMm = 1e4, kMinStepsPerVoxel = 1e3;

/// Returns the item that refers to the frame of reference, study and series of the images, and to the images.
DicomItem frame_of_reference(const DicomSource& source) {
  DicomItem series, study, frame;
  series.text({0x0020, 0x000e}, source.series).items({0x3006, 0x0016}, source.references());
  study.text({0x0008, 0x1150}, kStudy).text({0x0008, 0x1155}, source.study);
  study.item({0x3006, 0x0014}, series);
  frame.text({0x0020, 0x0052}, source.frame_of_reference).item({0x3006, 0x0012}, study);
  return frame;
}

/// Returns the number of steps per mm to which coordinates are rounded: a power of ten, at least 10,000 per mm and
/// 1,000 per voxel.
double steps_per_mm(const VolumeGeometry& grid) {
  return std::max(kMinStepsPerMm, std::pow(10, std::ceil(std::log10(kMinStepsPerVoxel / grid.spacing_mm.minCoeff()))));
}

DicomItem contour_item(const Polygon& polygon, std::size_t slice, std::size_t number, const DicomSource& source) {
  const Eigen::Affine3d world = source.geometry.world_from_index();
  const double steps = steps_per_mm(source.geometry);
  std::vector<double> data;
  for (const Eigen::Vector2d& p : polygon) {
    const Eigen::Vector3d mm = world * Eigen::Vector3d(p[0], p[1], static_cast<double>(slice));
    for (const double part : mm) data.push_back(std::round(part * steps) / steps);
  }
  DicomItem contour;
  contour.item({0x3006, 0x0016}, source.reference(slice)).text({0x3006, 0x0042}, "CLOSED_PLANAR");
  contour.text({0x3006, 0x0046}, std::to_string(polygon.size())).text({0x3006, 0x0048}, std::to_string(number));
  contour.numbers({0x3006, 0x0050}, data);
  return contour;
}

DicomItem contours_item(const MeshItem& mesh, const std::string& number, const DicomSource& source) {
  const Eigen::Affine3d index = source.geometry.index_from_world();
  const int slices = static_cast<int>(source.slices.size());
  std::vector<DicomItem> contours;
  std::vector<std::vector<Polygon>> sections = plane_sections(mesh.mesh, index, slices);
  for (std::size_t k = 0; k < sections.size(); ++k)
    for (const Polygon& polygon : with_keyholes(std::move(sections[k])))
      contours.push_back(contour_item(polygon, k, contours.size() + 1, source));
  const Colour& c = mesh.colour;
  DicomItem item;
  item.text({0x3006, 0x002a}, std::to_string(c.red) + "\\" + std::to_string(c.green) + "\\" + std::to_string(c.blue));
  item.text({0x3006, 0x0084}, number);
  if (!contours.empty()) item.items({0x3006, 0x0040}, contours);
  return item;
}

}  // namespace

void write_rtstruct(const std::filesystem::path& path, const Scene& scene, const std::vector<SegmentCode>& codes,
                    DicomSource source) {
  if (scene.meshes.empty())
    throw Error("cannot write " + quoted(path), "the scene has no segmentation", "create one first");
  DicomItem data = std::move(source.context);
  const DicomDateTime now = dicom_now();
  add_common_attributes(data, kStructureSet, "RTSTRUCT", now);
  data.text({0x0008, 0x1070}, "").text({0x3006, 0x0002}, "SimplexSeg").text({0x3006, 0x0004}, "Meshes of SimplexSeg");
  data.text({0x3006, 0x0008}, now.date).text({0x3006, 0x0009}, now.time).text({0x300e, 0x0002}, "UNAPPROVED");
  data.text({0x0008, 0x103e}, "Contours by SimplexSeg");
  data.item({0x3006, 0x0010}, frame_of_reference(source));
  std::vector<DicomItem> regions, contours, observations;
  std::vector<std::string> names;
  for (const MeshItem& mesh : scene.meshes) names.push_back(mesh.name);
  const std::vector<std::string> long_names = dicom_names(names, source), short_names = dicom_names(names, source, 16);
  for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
    const MeshItem& mesh = scene.meshes[m];
    const std::string number = std::to_string(m + 1);
    DicomItem& region = regions.emplace_back();
    region.text({0x3006, 0x0022}, number).text({0x3006, 0x0024}, source.frame_of_reference);
    region.text({0x3006, 0x0026}, long_names[m]).text({0x3006, 0x0036}, "SEMIAUTOMATIC");
    region.text({0x3006, 0x0038}, "SimplexSeg 2-simplex mesh");
    contours.push_back(contours_item(mesh, number, source));
    DicomItem& observation = observations.emplace_back();
    observation.text({0x3006, 0x0082}, number).text({0x3006, 0x0084}, number);
    observation.text({0x3006, 0x0085}, short_names[m]);
    add_segment_code(observation, {0x3006, 0x0086}, codes.at(m), source);
    observation.text({0x3006, 0x00a4}, "").text({0x3006, 0x00a6}, "");
  }
  data.items({0x3006, 0x0020}, regions).items({0x3006, 0x0039}, contours);
  data.items({0x3006, 0x0080}, observations);
  AtomicFile file(path);
  write_dicom(file, data, DicomCoding::Implicit);  // contours can exceed 65534 bytes
  file.commit();
}

}  // namespace simplexseg
