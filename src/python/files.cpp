// SPDX-License-Identifier: Apache-2.0
// Volumes and labels, read and written.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <map>
#include <optional>

#include "core/error.h"
#include "io/files.h"
#include "io/labels_io.h"
#include "io/volume_io.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/image.h"
#include "python/interruptible.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

void require_number(int number) {
  if (number < 1 || number > kMostVolumes)
    throw Error("volume number " + std::to_string(number), "it is out of range",
                "give 1 to " + std::to_string(kMostVolumes));
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

void write_image(const fs::path& path, const Image& image) { write_volume(path, image.volume); }

void write_label_image(const fs::path& path, const Image& labels, const std::map<int, py::str>& names) {
  std::vector<SegmentName> segments;
  segments.reserve(names.size());
  for (const auto& [value, name] : names) segments.push_back({value, name.cast<std::string>()});
  const WithoutGil released;
  write_labels(path, labels.volume, segments);
}

}  // namespace

void bind_files(py::module_& module) {
  module.def("read_volume", &read_image, py::arg("path"), py::kw_only(), py::arg("number") = 1, py::arg("series") = "",
             "Reads NIfTI, Analyze, NRRD, MetaImage, GIPL, MINC, a DICOM file or a folder with a DICOM series, voxels\n"
             "in their own type. number: which volume of a 4D file, from 1; series: UID of the series of a folder,\n"
             "\"\" for the largest. What the reader had to assume is a DataWarning. Raises Error for what is damaged,\n"
             "missing or cannot be read.");
  module.def(
      "read_info", &read_info, py::arg("path"), py::kw_only(), py::arg("number") = 1, py::arg("series") = "",
      "What a volume file says of itself, without its voxels: format, shape, dtype, spacing, origin, direction,\n"
      "components, volumes, files, names of labels, warnings. Raises Error as read_volume().");
  module.def("read_labels", &read_named_labels, py::arg("path"), py::kw_only(), py::arg("like") = py::none(),
             "Reads a label volume or the contours of a DICOM RT structure set: (labels, names by label). like: a\n"
             "volume onto whose grid they are brought. Raises Error as read_volume(), and where no label lies in it.");
  module.def("write_volume", &write_image, py::arg("path"), py::arg("volume"), py::call_guard<WithoutGil>(),
             "Writes .nii, .nii.gz, .nrrd or .mha, whole or not at all. Raises Error.");
  module.def("write_labels", &write_label_image, py::arg("path"), py::arg("labels"), py::arg("names") = py::dict(),
             "The same of labels, which must be integers; .seg.nrrd keeps the names. Raises Error.");
}

}  // namespace simplexseg::python
