// SPDX-License-Identifier: Apache-2.0
#include "io/volume/volume_io.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <new>

#include "core/expect.h"
#include "core/number_text.h"
#include "io/dicom/dicom.h"
#include "io/dicom/dicom_series.h"
#include "io/dicom/dicom_texts.h"
#include "io/dicom/gzipped_dicom.h"
#include "io/platform/atomic_file.h"
#include "io/platform/decompressing_reader.h"
#include "io/platform/files.h"
#include "io/source/volume_source.h"
#include "io/volume/gipl.h"
#include "io/volume/meta_image.h"
#include "io/volume/minc.h"
#include "io/volume/nifti.h"
#include "io/volume/nifti_write.h"
#include "io/volume/nrrd.h"
#include "io/volume/nrrd_segments.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

/// Throws Error if a file is compressed with gzip, and names its format if that can be read when decompressed.
void reject_compressed(const fs::path& path) {
  DecompressingReader reader(path);
  if (!reader.is_compressed()) return;
  std::string start(512, '\0');
  start.resize(reader.read(start.data(), start.size()));
  const char* format = nullptr;
  if (start.starts_with("NRRD000")) format = "NRRD";
  if (start.starts_with("\x89HDF")) format = "MINC";
  if (start.starts_with("ObjectType") || start.starts_with("NDims")) format = "MetaImage";
  if (format) {
    throw Error("cannot read " + quoted(path), std::string("it is a ") + format + " file compressed with gzip",
                "decompress it first");
  }
  throw Error("cannot read " + quoted(path), "its compressed content is not NIfTI, Analyze, GIPL or DICOM",
              "use a file of one of these formats");
}

VolumeSource open(const fs::path& path, int volume, const std::string& series) {
  std::error_code error;
  if (!series.empty()) return open_named_series(path, series, volume);
  if (fs::is_directory(path, error)) return open_dicom_series(path, volume);
  require_file(path);
  const std::string extension = extension_of(path);
  const auto is = [&](std::initializer_list<const char*> known) {
    return std::any_of(known.begin(), known.end(), [&](const char* e) { return extension == e; });
  };
  if (is({".nii", ".nii.gz", ".hdr", ".img", ".hdr.gz", ".img.gz"})) return open_nifti(path, volume);
  if (is({".mha", ".mhd"})) return open_meta_image(path, volume);
  if (is({".nrrd", ".nhdr"})) return open_nrrd(path, volume);
  if (is({".gipl", ".gipl.gz"})) return open_gipl(path, volume);
  if (is_dicomdir(path)) return open_only_series(path, volume);
  if (is({".mnc", ".mnc2"})) return open_minc(path, volume);
  // The extension is often missing or wrong, so the format is detected from the first bytes.
  if (has_dicom_preamble(path)) return open_dicom_file(path, volume);
  if (is_nifti_file(path)) return open_nifti(path, volume);
  if (is_gipl_file(path)) return open_gipl(path, volume);
  if (is_gzipped_dicom(path)) return open_gzipped_dicom(path, volume);
  reject_compressed(path);
  return open_dicom_file(path, volume);  // DICOM without preamble, or an Error that lists the supported formats
}

[[noreturn]] void throw_no_memory(const fs::path& path) {
  throw Error("cannot read " + quoted(path), "there is not enough memory for it", "crop or downsample it");
}

std::size_t count_not_finite(const Volume& volume) {
  return visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    std::size_t count = 0;
    if constexpr (std::is_floating_point_v<T>) {
      for (T v : volume.voxels<T>()) count += !(std::abs(v) <= std::numeric_limits<T>::max());
    }
    return count;
  });
}

bool is_nifti(const std::string& extension) { return extension == ".nii" || extension == ".nii.gz"; }

/// Warning that other programs cannot place voxels on a sheared grid; empty for axes at right angles.
std::string warning_of_shear(const fs::path& path, const VolumeGeometry& grid) {
  const auto degrees = shear_degrees(grid);
  if (!degrees) return "";
  return "the axes deviate by " + general_text(*degrees, 3) + " degrees from right angles: programs " +
         (is_nifti(extension_of(path)) ? "that use ITK (3D Slicer, ITK-SNAP) or the qform" : "without sheared grids") +
         " refuse the file or place it elsewhere; resample the image to axes at right angles for them";
}

std::string write(const fs::path& path, const Volume& volume, const std::string& nrrd_keys = "") {
  require_volume_name(path);
  if (volume.empty()) throw Error("cannot write " + quoted(path), "the volume is empty", "load a volume first");
  AtomicFile file(path);
  const std::string extension = extension_of(path);
  if (is_nifti(extension)) write_nifti(file, volume, extension == ".nii.gz");
  if (extension == ".nrrd") write_nrrd(file, volume, nrrd_keys);
  if (extension == ".mha") write_meta_image(file, volume);
  file.commit();
  return warning_of_shear(path, volume.geometry());
}

}  // namespace

VolumeSource open_volume(const fs::path& path, int volume, const std::string& series) {
  try {
    VolumeSource source = open(path, volume, series);
    if (volume > 1 && source.info.frame == 0) {
      require_one_value(path, source.info);
      select_volume(source.info, volume, "cannot read " + quoted(path));  // always throws
    }
    return source;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw_no_memory(path);
  } catch (const std::exception& exception) {  // for example from std::filesystem
    throw Error("cannot read " + quoted(path), one_line(exception.what()), "check the file");
  }
}

std::size_t available_memory() {
  std::ifstream stream("/proc/meminfo");
  std::string key, unit;
  std::size_t kilobytes = 0;
  while (stream >> key >> kilobytes && std::getline(stream, unit)) {
    if (key == "MemAvailable:") return kilobytes * 1024;
  }
  return 0;
}

VolumeInfo read_volume_info(const fs::path& path, int volume, const std::string& series) {
  return open_volume(path, volume, series).info;
}

int count_volumes(const fs::path& path) {
  const VolumeInfo info = read_volume_info(path);
  return info.frame > 0 ? info.frames : 1;
}

LoadedVolume load_volume(const fs::path& path, int volume, const std::string& series) {
  return load_volume(open_volume(path, volume, series), path);
}

LoadedVolume load_volume(const VolumeSource& source, const fs::path& path, std::optional<int> segment) {
  SIMPLEXSEG_EXPECT(!segment || source.read_segment);
  const VolumeInfo& info = source.info;
  require_one_value(path, info);
  const double needed =
      double(info.geometry.voxel_count()) * double(bytes_per_voxel(info.type)) + double(source.extra_bytes);
  const std::size_t available = available_memory();
  if (available > 0 && needed > double(available)) {
    throw Error("cannot read " + quoted(path),
                "it needs " + format_bytes(needed) + " of memory, but only " + format_bytes(double(available)) +
                    " are available",
                "crop or downsample it");
  }
  LoadedVolume loaded;
  try {
    loaded.volume = segment ? source.read_segment(*segment) : source.read();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw_no_memory(path);
  } catch (const std::exception& exception) {
    throw Error("cannot read " + quoted(path), one_line(exception.what()), "check the file");
  }
  loaded.format = info.format;
  loaded.frames = info.frames;
  loaded.frame = info.frame;
  loaded.low_is_bright = info.low_is_bright;
  loaded.segments = info.segments;
  loaded.is_dicom = !source.dicom.empty();
  if (loaded.is_dicom) {
    const DicomTexts texts = read_dicom_texts(source.dicom.front().file);
    loaded.patient = texts.patient.empty() ? texts.patient_id : texts.patient;
    loaded.series = texts.series;
    if (texts.modality == "CT") loaded.intensity_unit = "HU";
    if (texts.modality == "PT") {
      const PetAttributes pet = read_pet_attributes(source.dicom.front().file);
      loaded.intensity_unit = unit_of_pet(pet);
      loaded.uptake = uptake_scale(pet);
    }
  }
  loaded.warnings = info.warnings;
  if (source.voxel_warnings && !segment)
    loaded.warnings.insert(loaded.warnings.end(), source.voxel_warnings->begin(), source.voxel_warnings->end());
  if (const std::size_t count = count_not_finite(loaded.volume)) {
    loaded.warnings.push_back(
        counted(static_cast<std::int64_t>(count), "voxel is not a finite number", "voxels are not finite numbers"));
  }
  return loaded;
}

Volume read_volume(const fs::path& path) { return load_volume(path).volume; }

void require_volume_name(const fs::path& path) {
  const std::string extension = extension_of(path);
  if (is_nifti(extension) || extension == ".nrrd" || extension == ".mha") return;
  throw Error("cannot write " + quoted(path), "the extension '" + extension + "' is not supported",
              "use .nii.gz, .nii, .nrrd or .mha");
}

std::string write_volume(const fs::path& path, const Volume& volume) { return write(path, volume); }

std::string write_labels(const fs::path& path, const Volume& labels, const std::vector<SegmentName>& names) {
  if (labels.type() == VoxelType::Float32 || labels.type() == VoxelType::Float64) {
    throw Error("cannot write " + quoted(path),
                std::string("labels must be integers, but these are ") + to_string(labels.type()),
                "convert them to integers");
  }
  return write(path, labels, is_segment_name(path) && !labels.empty() ? segment_fields(labels, names) : "");
}

}  // namespace simplexseg
