// SPDX-License-Identifier: Apache-2.0
#include "io/dicom/dicom.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <numeric>
#include <set>
#include <vector>

#include "io/dicom/dicom_pixels.h"
#include "io/dicom/dicom_position.h"
#include "io/dicom/dicom_scan.h"
#include "io/dicom/dicom_segments.h"
#include "io/dicom/dicom_stack.h"
#include "io/dicom/dicom_volumes.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/platform/worker_process.h"
#include "io/source/stored_header.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

void require_readable(const std::vector<DicomSlice>& slices) {
  std::vector<std::string> names;
  std::string why, remedy;
  for (const DicomSlice& s : slices) {
    if (s.unreadable.empty()) continue;
    if (why.empty()) why = s.unreadable, remedy = s.remedy;
    names.push_back(name_of(s));
  }
  if (names.empty()) return;
  if (slices.size() > 1) why += ": " + list_of(names);
  throw Error("cannot read " + quoted(slices.size() == 1 ? slices[0].file : slices[0].file.parent_path()), why, remedy);
}

Volume as_32_bits(const Volume& volume) {
  Volume wide(volume.geometry(), VoxelType::Int32);
  std::ranges::copy(volume.voxels<std::int16_t>(), wide.voxels<std::int32_t>().begin());
  return wide;
}

Volume read_slices(const std::vector<DicomSlice>& slices, const VolumeInfo& info) {
  Volume volume(info.geometry, info.type);
  // The slices are read in the order of their files, so that each multi-frame file is opened only once.
  std::vector<std::size_t> order(slices.size());
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return slices[a].file < slices[b].file; });
  std::vector<DicomSlice> in_order;
  in_order.reserve(order.size());
  for (const std::size_t i : order) in_order.push_back(slices[i]);
  DicomFrames frames(in_order);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto read = [&] {
      const std::size_t slice_bytes = volume.bytes() / slices.size();
      return frames.read(in_order[i], volume.type(), static_cast<std::byte*>(volume.data()) + order[i] * slice_bytes);
    };
    if (!read() && volume.type() == VoxelType::Int16) {
      volume = as_32_bits(volume);
      read();
    }
    report_progress(static_cast<double>(i + 1), static_cast<double>(order.size()));
  }
  return volume;
}

/// Returns the voxel type of the volume: the type of the slices, or a floating-point type when their types or rescaling
/// differ.
VoxelType common_type(const std::vector<DicomSlice>& slices) {
  VoxelType type = voxel_type_of(slices.front());
  for (const DicomSlice& s : slices) {
    if (voxel_type_of(s) == type && s.slope == slices[0].slope && s.intercept == slices[0].intercept) continue;
    if (bytes_per_voxel(type) > 4 || s.pixels.stored_bits > 24) return VoxelType::Float64;
    type = VoxelType::Float32;
  }
  return type;
}

void place_slices(std::vector<DicomSlice>& slices, VolumeInfo& info, const std::string& series_name) {
  const DicomSlice first = slices.front();
  const bool in_order = slices.size() > 1 && !first.position && !first.assumed.empty();
  if (slices.size() > 1 && !in_order) require_one_stack(slices, series_name);
  info.geometry.size = {first.pixels.columns, first.pixels.rows, static_cast<int>(slices.size())};
  if (first.spacing_mm)
    info.geometry.spacing_mm.head<2>() = *first.spacing_mm;
  else
    info.warnings.push_back("no pixel spacing: 1 mm is assumed");
  if (slices.size() == 1 || in_order) {
    const double stated = first.slice_distance_mm.value_or(0);
    const double thick = stated > 0 ? stated : first.thickness_mm.value_or(0);
    if (thick > 0) info.geometry.spacing_mm[2] = thick;
  }
  if (!first.assumed.empty()) info.warnings.push_back(first.assumed);
  if (!first.ignored.empty()) info.warnings.push_back(first.ignored);
  if (first.position && first.axes) {
    stack(slices, info.geometry, info.warnings, series_name);
  } else if (first.axes) {
    info.geometry.direction.leftCols<2>() = *first.axes;
    info.geometry.direction.col(2) = slice_normal(first);
    info.warnings.push_back("no position: the first voxel is placed at the origin");
  } else {
    info.warnings.push_back(std::string(first.position ? "no orientation" : "no position or orientation") +
                            ": the patient's left and right are unknown");
  }
}

int count_files(const std::vector<DicomSlice>& slices) {
  std::set<fs::path> files;
  for (const DicomSlice& s : slices) files.insert(s.file);
  return static_cast<int>(files.size());
}

}  // namespace

VolumeSource open_dicom_slices(std::vector<DicomSlice> slices, const std::string& format,
                               const std::string& series_name, int volume) {
  VolumeSource source;
  VolumeInfo& info = source.info;
  info.format = format;
  info.components = slices.front().photometric.starts_with("PALETTE") ? 3 : slices.front().pixels.samples;
  if (info.components == 1) require_readable(slices);
  if (is_segmentation(slices.front())) {
    const int files = count_files(slices);
    source = open_segments(std::move(slices), series_name);
    source.info.format = "DICOM SEG", source.info.file_count = files;
    return source;
  }
  DicomVolumes split = split_volumes(std::move(slices), series_name);
  info.frames = static_cast<int>(split.volumes.size());
  const auto place = static_cast<std::size_t>(volume) - 1;
  info.times_s = times_of(split);
  select_volume(info, volume, "cannot read " + series_name, place < split.names.size() ? split.names[place] : "");
  if (!split.note.empty()) info.warnings.push_back(split.note);
  slices = std::move(split.volumes[place]);
  info.file_count = count_files(slices);
  place_slices(slices, info, series_name);
  info.low_is_bright = slices.front().photometric == "MONOCHROME1";
  if (info.low_is_bright)
    info.warnings.push_back("MONOCHROME1: low values are displayed bright; the voxel values are unchanged");
  info.type = common_type(slices);
  info.geometry.validate("cannot read " + series_name);
  if (!slices.front().frame_of_reference.empty())
    keep_header(info.geometry, DicomFrame{slices.front().frame_of_reference});
  for (const DicomSlice& s : slices) source.extra_bytes = std::max(source.extra_bytes, buffer_bytes(s.pixels));
  source.dicom = std::move(slices);
  source.read = [slices = source.dicom, info] { return read_slices(slices, info); };
  return source;
}

bool has_dicom_preamble(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  char magic[4] = {};
  stream.seekg(128);
  return stream.read(magic, 4) && std::memcmp(magic, "DICM", 4) == 0;
}

VolumeSource open_dicom_file(const fs::path& path, int volume) {
  require_file(path);
  std::vector<DicomSlice> slices;
  try {
    slices = scan_dicom(path);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), message_of(exception), "copy or export the file again");
  }
  if (slices.empty()) {
    const std::string kind = sop_class_name(path);
    if (has_dicom_preamble(path) || !kind.empty()) {
      throw Error("cannot read " + quoted(path),
                  "this DICOM file contains no image" + (kind.empty() ? "" : " (" + kind + ")"),
                  "open the folder of an image series");
    }
    throw Error("cannot read " + quoted(path), "its format is not supported",
                "choose NIfTI, Analyze, MetaImage, NRRD, GIPL, MINC, a DICOM file or the folder of a DICOM series");
  }
  const bool alone = slices.size() == 1;
  VolumeSource source = open_dicom_slices(std::move(slices), "DICOM", quoted(path), volume);
  if (alone) source.info.warnings.push_back("only one DICOM slice: open its folder to load the whole series");
  return source;
}

}  // namespace simplexseg
