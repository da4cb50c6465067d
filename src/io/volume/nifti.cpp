// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nifti.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "io/platform/decompressing_reader.h"
#include "io/platform/files.h"
#include "io/source/stored_voxels.h"
#include "io/volume/nifti_geometry.h"
#include "io/volume/nifti_header.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr const char* kCopyAgain = "copy or export the file again";

/// File of kind ".hdr" or ".img" in the pair NAME.hdr and NAME.img to which `path` belongs; with ".gz" if only the
/// compressed file exists.
fs::path partner(const fs::path& path, const char* kind) {
  fs::path stem = path;
  if (extension_of(path).ends_with(".gz")) stem.replace_extension();
  const bool upper = stem.extension() == ".HDR" || stem.extension() == ".IMG";
  stem.replace_extension(upper ? (std::string(kind) == ".hdr" ? ".HDR" : ".IMG") : kind);
  std::error_code error;
  const fs::path compressed = stem.string() + ".gz";
  return !fs::exists(stem, error) && fs::exists(compressed, error) ? compressed : stem;
}

/// Opens a volume, or, with `vectors`, one of the components of a vector image. Sets the intent code of the header.
VolumeSource open_part(const fs::path& path, int volume, bool vectors, int& intent);

}  // namespace

bool is_nifti_file(const fs::path& path) {
  DecompressingReader reader(path);
  return read_nifti_header(reader).version > 0;
}

VolumeSource open_nifti(const fs::path& path, int volume) {
  int intent = 0;
  return open_part(path, volume, false, intent);
}

NiftiVectors read_nifti_vectors(const fs::path& path) {
  NiftiVectors result;
  for (int component = 0; component < 3; ++component) {
    const VolumeSource source = open_part(path, component + 1, true, result.intent);
    result.grid = source.info.geometry;
    const Volume part = source.read();
    result.vectors.resize(part.geometry().voxel_count());
    visit_voxel_type(part.type(), [&]<class T>(std::type_identity<T>) {
      const auto voxels = part.voxels<T>();
      for (std::size_t n = 0; n < voxels.size(); ++n) result.vectors[n][component] = static_cast<float>(voxels[n]);
    });
  }
  return result;
}

namespace {

VolumeSource open_part(const fs::path& path, int volume, bool vectors, int& intent) {
  const std::string extension = extension_of(path), name = quoted(path);
  const bool pair = extension.starts_with(".hdr") || extension.starts_with(".img");
  const fs::path header_path = pair ? partner(path, ".hdr") : path;
  std::error_code error;
  if (pair && !fs::exists(header_path, error) && fs::exists(path, error)) {
    throw Error("cannot read " + name, "its header " + quoted(header_path) + " is missing",
                "move both files to one folder");
  }
  DecompressingReader reader(header_path);
  const NiftiHeader h = read_nifti_header(reader);
  if (h.version < 0 || (h.version == 0 && !pair)) {
    std::array<unsigned char, 540> rest;
    if (h.version < 0 && reader.is_compressed() && reader.read(rest.data(), 1) == 0 && reader.damaged_at_end()) {
      throw Error("cannot read " + name, "its compressed data is damaged within the header", kCopyAgain);
    }
    throw Error("cannot read " + name, "it does not begin with a NIfTI header",
                "rename it with the extension of its format");
  }
  VolumeInfo info;
  StoredVoxels v;
  const fs::path path_of_voxels = h.single_file || !pair ? header_path : partner(path, ".img");
  const bool single = path_of_voxels == header_path;
  v.files = {path_of_voxels};
  info.format = h.version == 0 ? "Analyze 7.5" : h.version == 1 ? "NIfTI-1" : "NIfTI-2";
  info.file_count = single ? 1 : 2;
  set_sizes(h, info, name);
  if (vectors) {  // components are stored one after the other, as volumes are
    if (info.components != 3 || info.frames != 1)
      throw Error("cannot read " + name, "it has no three components for each voxel, as a displacement field has",
                  "select a displacement field");
    std::swap(info.components, info.frames);
  }
  intent = h.version == 2 ? h.at<std::int32_t>(504) : h.at<std::int16_t>(68);
  v.type = stored_type(h.datatype, name);
  set_geometry(h, info);
  v.swapped = h.swapped;
  v.slope = h.slope;
  v.intercept = std::isfinite(h.intercept) ? h.intercept : 0;
  // A slope of 0 means that voxels are not scaled. Scaled integers become float, as in ITK.
  v.rescaled = std::isfinite(v.slope) && v.slope != 0 && (v.slope != 1 || v.intercept != 0);
  if (!std::isfinite(h.vox_offset) || h.vox_offset < 0 || h.vox_offset > 1e15) {
    throw Error("cannot read " + name, "its header has an invalid voxel offset", kCopyAgain);
  }
  const double smallest = single ? (h.version == 2 ? 544 : 352) : 0;
  v.skipped = static_cast<std::uint64_t>(std::max(h.vox_offset, smallest));
  if (single || fs::exists(path_of_voxels, error))
    v.compression = DecompressingReader(path_of_voxels).is_compressed() ? Compression::Deflate : Compression::None;
  return open_stored(std::move(info), std::move(v), path, volume);
}

}  // namespace

}  // namespace simplexseg
