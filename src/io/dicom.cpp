// SPDX-License-Identifier: Apache-2.0
// ITK comes first: it brings an Eigen of its own.
#include <itkGDCMImageIO.h>

#include "io/dicom.h"

#include <algorithm>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <vector>

#include "io/dicom_slice.h"
#include "io/dicom_stack.h"
#include "io/files.h"
#include "io/itk_quiet.h"
#include "io/itk_types.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

itk::GDCMImageIO::Pointer open_pixels(const DicomSlice& slice) {
  const auto io = itk::GDCMImageIO::New();
  try {
    without_aborting([&] {
      if (!io->CanReadFile(slice.file.c_str())) throw std::runtime_error("its pixels are coded in an unknown way");
      io->SetFileName(slice.file.string());
      io->ReadImageInformation();
    });
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(slice.file), plain_words(exception), "copy or export the file again");
  }
  return io;
}

void require_readable(const std::vector<DicomSlice>& slices) {
  std::vector<std::string> names;
  std::string why;
  for (const DicomSlice& s : slices) {
    if (s.unreadable.empty()) continue;
    if (why.empty()) why = s.unreadable;
    names.push_back(name_of(s));
  }
  if (names.empty()) return;
  if (slices.size() > 1) why += ": " + list_of(names);
  throw Error("cannot read " + quoted(slices.size() == 1 ? slices[0].file : slices[0].file.parent_path()), why,
              "copy or export it again");
}

Volume read_slices(const std::vector<DicomSlice>& slices, const VolumeInfo& info) {
  const QuietLibraries quiet;
  require_readable(slices);
  Volume volume(info.geometry, info.type);
  const std::size_t count = info.geometry.voxel_count() / slices.size();
  std::vector<unsigned char> other;  // for a slice whose type is not the volume's
  for (std::size_t k = 0; k < slices.size(); ++k) {
    const auto io = open_pixels(slices[k]);
    const ItkVoxels voxels = itk_voxels_of(*io, quoted(slices[k].file));
    const std::size_t bytes = static_cast<std::size_t>(io->GetImageSizeInBytes());
    if (io->GetNumberOfComponents() != 1 || voxels.wide || bytes != count * bytes_per_voxel(voxels.type)) {
      throw Error("cannot read " + quoted(slices[k].file),
                  "its pixels are of another kind than those of the other slices",
                  "put slices of one kind into a folder of their own");
    }
    auto* to = static_cast<unsigned char*>(volume.data()) + k * count * bytes_per_voxel(info.type);
    const bool direct = voxels.type == info.type;
    if (!direct) other.resize(bytes);
    try {
      without_aborting([&] { read_whole(*io, direct ? to : other.data()); });
    } catch (const std::exception& exception) {
      throw Error("cannot read " + quoted(slices[k].file), plain_words(exception), "copy or export the file again");
    }
    if (direct) continue;
    visit_voxel_type(voxels.type, [&]<class From>(std::type_identity<From>) {
      const auto* from = reinterpret_cast<const From*>(other.data());
      visit_voxel_type(info.type, [&]<class To>(std::type_identity<To>) {
        std::transform(from, from + count, reinterpret_cast<To*>(to), [](From v) { return static_cast<To>(v); });
      });
    });
  }
  return volume;
}

/// The volume of slices that are known to be of one series; `what` names it in messages.
VolumeSource open_slices(std::vector<DicomSlice> slices, const std::string& format, const std::string& what) {
  VolumeSource source;
  VolumeInfo& info = source.info;
  info.format = format;
  info.file_count = static_cast<int>(slices.size());
  if (slices.size() > 1) require_one_stack(slices, what);
  const DicomSlice first = slices.front();
  if (slices.size() == 1 && first.frames > 1) {
    // The frames' places are in nested sequences (or in a dose grid's offsets): GDCM knows them.
    describe(*open_pixels(first), info);
    info.warnings.push_back("many frames in one file: they are taken as evenly spaced slices in their order");
  } else {
    info.geometry.size = {first.columns, first.rows, static_cast<int>(slices.size())};
    if (first.spacing_mm)
      info.geometry.spacing_mm.head<2>() = *first.spacing_mm;
    else
      info.warnings.push_back("no pixel spacing: 1 mm is assumed");
    if (slices.size() == 1) {
      const auto thick = first.between_mm && *first.between_mm > 0 ? first.between_mm : first.thickness_mm;
      if (thick && *thick > 0) info.geometry.spacing_mm[2] = *thick;
    }
    if (first.position && first.axes) {
      stack(slices, info.geometry, info.warnings, what);
    } else {
      info.warnings.push_back("no position or orientation: which side is the patient's left is not known");
    }
  }
  const auto io = open_pixels(slices.front());
  info.components = static_cast<int>(io->GetNumberOfComponents());
  info.type = itk_voxels_of(*io, quoted(slices.front().file)).type;
  for (const DicomSlice& s : slices) {
    if (s.pixel_kind != first.pixel_kind) info.type = VoxelType::Float32;  // rescaled differently from slice to slice
  }
  info.geometry.validate("cannot read " + what);
  if (info.components == 1) require_readable(slices);
  source.read = [slices = std::move(slices), info] { return read_slices(slices, info); };
  return source;
}

}  // namespace

bool looks_like_dicom(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  char magic[4] = {};
  stream.seekg(128);
  return stream.read(magic, 4) && std::memcmp(magic, "DICM", 4) == 0;
}

VolumeSource open_dicom_file(const fs::path& path) {
  require_file(path);
  const QuietLibraries quiet;
  std::optional<DicomSlice> slice;
  try {
    slice = scan_dicom(path);
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), plain_words(exception), "copy or export the file again");
  }
  if (!slice) {
    if (looks_like_dicom(path)) {
      throw Error("cannot read " + quoted(path), "this DICOM file holds no image",
                  "open the folder of an image series");
    }
    throw Error("cannot read " + quoted(path), "it is none of the formats that can be read",
                "give NIfTI, Analyze, MetaImage, NRRD, GIPL, MINC 2, a DICOM file, or the folder of a DICOM series");
  }
  VolumeSource source = open_slices({*slice}, "DICOM", quoted(path));
  if (slice->frames == 1) source.info.warnings.push_back("one DICOM slice: open its folder for the whole series");
  return source;
}

VolumeSource open_dicom_series(const fs::path& folder) {
  const QuietLibraries quiet;
  std::error_code error;
  std::vector<fs::path> files;
  bool has_folders = false;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    std::error_code ignored;
    if (it->is_directory(ignored)) has_folders = true;
    if (it->is_regular_file(ignored) && it->file_size(ignored) > 0) files.push_back(it->path());
  }
  if (error) throw Error("cannot read the folder " + quoted(folder), error.message(), "check its permissions");
  std::sort(files.begin(), files.end());
  std::map<std::string, std::vector<DicomSlice>> series;
  std::vector<std::string> broken;
  for (const fs::path& file : files) {
    try {
      if (std::optional<DicomSlice> slice = scan_dicom(file)) series[slice->series].push_back(std::move(*slice));
    } catch (const std::exception&) {
      broken.push_back(quoted(file.filename()));
    }
  }
  if (series.empty()) {
    throw Error(
        "cannot read the folder " + quoted(folder),
        broken.empty() ? "it holds no DICOM images" : "its DICOM files are damaged: " + list_of(broken),
        has_folders ? "name one of its subfolders, which are not searched" : "name a file or the folder of a series");
  }
  const auto size_of = [](const std::vector<DicomSlice>& slices) {
    std::size_t count = 0;
    for (const DicomSlice& s : slices) count += static_cast<std::size_t>(s.frames);
    return count;
  };
  const auto largest = std::max_element(series.begin(), series.end(), [&](const auto& a, const auto& b) {
    return size_of(a.second) < size_of(b.second);
  });
  const auto named = [&](const std::vector<DicomSlice>& slices) {
    const std::string& text = slices.front().description.empty() ? slices.front().series : slices.front().description;
    return "'" + text + "' (" + std::to_string(size_of(slices)) + " slices, from " + name_of(slices.front()) + ")";
  };
  std::vector<std::string> others;
  for (auto it = series.begin(); it != series.end(); ++it) {
    if (it != largest) others.push_back(named(it->second));
  }
  const std::string chosen = named(largest->second);
  VolumeSource source =
      open_slices(std::move(largest->second), "DICOM series", "the DICOM series in " + quoted(folder));
  if (!others.empty()) {
    source.info.warnings.push_back(std::to_string(others.size() + 1) + " series in the folder: the largest, " + chosen +
                                   ", is taken; left out: " + list_of(others));
  }
  if (!broken.empty()) source.info.warnings.push_back("damaged files are left out: " + list_of(broken));
  return source;
}

}  // namespace simplexseg
