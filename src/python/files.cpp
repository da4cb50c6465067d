// SPDX-License-Identifier: Apache-2.0
// Reading and writing of volumes and labels.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <optional>

#include "core/error.h"
#include "io/labels/labels_io.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/image.h"
#include "python/interruptible.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

void require_number(int number) {
  if (number < 1 || number > kMaxVolumes)
    throw Error("volume number " + std::to_string(number), "it is out of range",
                "use 1 to " + std::to_string(kMaxVolumes));
}

Image read_image(const fs::path& path, int number, const std::string& series) {
  require_number(number);
  LoadedVolume loaded = interruptible([&] { return load_volume(path, number, series); });
  warn(loaded.warnings);
  return {std::move(loaded.volume), fs::absolute(path), number, series, loaded.low_is_bright};
}

py::dict names_of(const std::vector<SegmentName>& segments) {
  py::dict names;
  for (const SegmentName& segment : segments) names[py::int_(segment.value)] = python_text(segment.name);
  return names;
}

py::dict read_info(const fs::path& path, int number, const std::string& series) {
  require_number(number);
  const VolumeInfo info = interruptible([&] { return read_volume_info(path, number, series); });
  const auto& size = info.geometry.size;
  py::dict result;
  result["format"] = python_text(info.format);
  result["shape"] = py::make_tuple(size[0], size[1], size[2]);
  result["dtype"] = dtype_of(info.type);
  result["spacing"] = tuple_of(info.geometry.spacing_mm);
  result["origin"] = tuple_of(info.geometry.origin_mm);
  result["direction"] = array_of(info.geometry.direction);
  result["components"] = info.components;
  result["volumes"] = info.frames;
  result["files"] = info.file_count;
  result["names"] = names_of(info.segments);
  result["warnings"] = python_texts(info.warnings);
  return result;
}

py::tuple read_named_labels(const fs::path& path, const std::optional<Image>& like) {
  struct Read {
    Volume volume;
    std::vector<SegmentName> segments;
    std::vector<std::string> warnings;
  };
  Read read = interruptible([&]() -> Read {
    LoadedLabels labels = load_labels(path);
    if (!like) return {std::move(labels.volume), std::move(labels.segments), std::move(labels.warnings)};
    Read onto{{}, std::move(labels.segments), {}};
    onto.volume = load_labels_onto(path, like->volume.geometry(), "the volume", onto.warnings);
    return onto;
  });
  warn(read.warnings);
  return py::make_tuple(Image{std::move(read.volume), fs::absolute(path)}, names_of(read.segments));
}

void warn_if_any(const std::string& warning) {
  if (!warning.empty()) warn({warning});
}

void write_image(const fs::path& path, const Image& image) {
  std::string warning;
  {
    const WithoutGil released;
    warning = write_volume(path, image.volume);
  }
  warn_if_any(warning);
}

void write_label_image(const fs::path& path, const Image& labels, const std::map<int, py::str>& names) {
  std::vector<SegmentName> segments;
  segments.reserve(names.size());
  for (const auto& [value, name] : names) segments.push_back({value, name.cast<std::string>()});
  std::string warning;
  {
    const WithoutGil released;
    warning = write_labels(path, labels.volume, segments);
  }
  warn_if_any(warning);
}

}  // namespace

void bind_files(py::module_& module) {
  module.def(
      "read_volume", &read_image, py::arg("path"), py::kw_only(), py::arg("number") = 1, py::arg("series") = "",
      "Reads a volume: NIfTI, Analyze, NRRD, MetaImage, GIPL, MINC, a DICOM file or a folder with a DICOM series.\n"
      "Keeps the type of the voxels. number: volume of a 4D file, counted from 1; series: UID of a series in a\n"
      "folder, \"\" for the largest. Issues a DataWarning for each assumption of the reader. Raises Error if the\n"
      "file is missing, damaged or unsupported.");
  module.def(
      "read_info", &read_info, py::arg("path"), py::kw_only(), py::arg("number") = 1, py::arg("series") = "",
      "Reads the description of a volume file without its voxels: format, shape, dtype, spacing, origin, direction,\n"
      "components, volumes, files, names of labels, warnings. Raises Error like read_volume().");
  module.def(
      "read_labels", &read_named_labels, py::arg("path"), py::kw_only(), py::arg("like") = py::none(),
      "Reads a label volume or the contours of a DICOM RT structure set. Returns (labels, names by label). like:\n"
      "volume onto whose grid the labels are resampled. Raises Error like read_volume(), and if no label lies\n"
      "within that grid.");
  module.def("write_volume", &write_image, py::arg("path"), py::arg("volume"),
             "Writes a volume (.nii, .nii.gz, .nrrd, .mha) atomically. A grid that was read from a file of the same\n"
             "format keeps that file's header fields. Issues a DataWarning for a sheared grid. Raises Error if the\n"
             "file cannot be written.");
  module.def("write_labels", &write_label_image, py::arg("path"), py::arg("labels"), py::arg("names") = py::dict(),
             "Writes labels like write_volume(). labels: integers; names: stored in .seg.nrrd files. Raises Error.");
}

}  // namespace simplexseg::python
