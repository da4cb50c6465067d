// SPDX-License-Identifier: Apache-2.0
#include "io/nifti.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "io/files.h"
#include "io/gz_file.h"
#include "io/nifti_geometry.h"
#include "io/nifti_header.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr const char* kExportAgain = "copy or export the file again";

void swap_bytes(unsigned char* data, std::size_t count, int size) {
  for (std::size_t i = 0; i < count; ++i, data += size) std::reverse(data, data + size);
}

/// f with the type in which the file stores its voxels.
template <class F>
void visit_stored(const StoredType& stored, F&& f) {
  if (stored.wide && stored.type == VoxelType::Int32) return f(std::type_identity<std::int64_t>{});
  if (stored.wide) return f(std::type_identity<std::uint64_t>{});
  visit_voxel_type(stored.type, f);
}

struct Voxels {
  fs::path path;  ///< the file that they are in
  std::size_t offset;
  StoredType stored;
  bool swapped, rescaled;
  double slope, intercept;
  VolumeInfo info;
};

Volume read_voxels(const Voxels& v) {
  GzReader reader(v.path);
  Volume volume(v.info.geometry, v.info.type);
  const std::size_t count = v.info.geometry.voxel_count();
  const double wanted = double(v.offset) + double(count) * v.stored.bytes;
  const auto throw_damaged = [&] {
    throw Error("cannot read " + quoted(v.path), "its packed data are damaged (checksum)", kExportAgain);
  };
  const auto require = [&](std::size_t got, std::size_t asked, std::size_t before) {
    // A read that meets bad data gives nothing of what it had unpacked before: damage is asked for first.
    if (got != asked && reader.damaged()) throw_damaged();
    if (got != asked) throw_truncated(v.path, wanted, double(v.offset + before + got));
  };
  if (!reader.skip(v.offset)) throw_truncated(v.path, wanted, double(v.offset));
  if (!v.rescaled && !v.stored.wide) {
    auto* to = static_cast<unsigned char*>(volume.data());
    require(reader.read(to, volume.bytes()), volume.bytes(), 0);
    if (v.swapped) swap_bytes(to, count, v.stored.bytes);
  } else {
    constexpr std::size_t block_size = 1 << 18;
    std::vector<unsigned char> block(block_size * v.stored.bytes);
    for (std::size_t first = 0; first < count; first += block_size) {
      const std::size_t n = std::min(block_size, count - first), bytes = n * v.stored.bytes;
      require(reader.read(block.data(), bytes), bytes, first * v.stored.bytes);
      if (v.swapped) swap_bytes(block.data(), n, v.stored.bytes);
      visit_stored(v.stored, [&]<class From>(std::type_identity<From>) {
        const auto* from = reinterpret_cast<const From*>(block.data());
        visit_voxel_type(v.info.type, [&]<class To>(std::type_identity<To>) {
          To* to = volume.voxels<To>().data() + first;
          if constexpr (std::is_floating_point_v<To>) {
            for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<To>(double(from[i]) * v.slope + v.intercept);
          } else if constexpr (sizeof(From) == 8 && sizeof(To) == 4 && std::is_integral_v<From>) {
            narrow(from, n, to, quoted(v.path));
          }
        });
      });
    }
  }
  if (reader.damaged_at_end()) throw_damaged();
  return volume;
}

/// name.hdr, name.img and their .gz: the header's or the data's file.
fs::path partner(const fs::path& path, const char* kind) {
  fs::path stem = path;
  if (extension_of(path).ends_with(".gz")) stem.replace_extension();
  const bool upper = stem.extension() == ".HDR" || stem.extension() == ".IMG";
  stem.replace_extension(upper ? (std::string(kind) == ".hdr" ? ".HDR" : ".IMG") : kind);
  std::error_code error;
  const fs::path packed = stem.string() + ".gz";
  return !fs::exists(stem, error) && fs::exists(packed, error) ? packed : stem;
}

}  // namespace

bool looks_like_nifti(const fs::path& path) {
  GzReader reader(path);
  return read_nifti_header(reader).version > 0;
}

VolumeSource open_nifti(const fs::path& path) {
  const std::string extension = extension_of(path), name = quoted(path);
  const bool pair = extension.starts_with(".hdr") || extension.starts_with(".img");
  const fs::path header_path = pair ? partner(path, ".hdr") : path;
  std::error_code error;
  if (pair && !fs::exists(header_path, error) && fs::exists(path, error)) {
    throw Error("cannot read " + name, "its header " + quoted(header_path) + " is missing",
                "put both files in one folder");
  }
  GzReader reader(header_path);
  const NiftiHeader h = read_nifti_header(reader);
  if (h.version < 0 || (h.version == 0 && !pair)) {
    std::array<unsigned char, 540> rest;
    if (h.version < 0 && reader.packed() && reader.read(rest.data(), 1) == 0 && reader.damaged_at_end()) {
      throw Error("cannot read " + name, "its packed data end or are damaged within the header", kExportAgain);
    }
    throw Error("cannot read " + name, "it does not begin with a NIfTI header",
                "give it the extension of its real format, or export it again as NIfTI");
  }
  Voxels v;
  v.path = h.single_file || !pair ? header_path : partner(path, ".img");
  if (v.path != header_path && !fs::exists(v.path, error)) {
    throw Error("cannot read " + name, "only the header is there, " + quoted(v.path) + " with the voxels is missing",
                "put both files in one folder");
  }
  v.info.format = h.version == 0 ? "Analyze 7.5" : h.version == 1 ? "NIfTI-1" : "NIfTI-2";
  v.info.file_count = v.path == header_path ? 1 : 2;
  set_sizes(h, v.info, name);
  v.stored = stored_type(h.datatype, name);
  set_geometry(h, v.info);
  v.info.geometry.validate("cannot read " + name);
  warn_if_sheared(v.info);

  v.swapped = h.swapped && v.stored.bytes > 1;
  v.slope = h.slope;
  v.intercept = std::isfinite(h.intercept) ? h.intercept : 0;
  // As ITK: slope 0 means none, integers become float.
  v.rescaled = std::isfinite(v.slope) && std::abs(v.slope) > std::numeric_limits<double>::epsilon() &&
               (v.slope != 1 || v.intercept != 0);
  const bool is_float = v.stored.type == VoxelType::Float32 || v.stored.type == VoxelType::Float64;
  v.info.type = v.rescaled && !is_float ? VoxelType::Float32 : v.stored.type;
  if (v.stored.wide && !v.rescaled) v.info.warnings.push_back("64-bit integers are kept in 32 bits");
  if (!std::isfinite(h.vox_offset) || h.vox_offset < 0 || h.vox_offset > 1e15) {
    throw Error("cannot read " + name, "its header gives no sensible start of the voxels", kExportAgain);
  }
  const double smallest = v.path == header_path ? (h.version == 2 ? 544 : 352) : 0;
  v.offset = static_cast<std::size_t>(std::max(h.vox_offset, smallest));

  // Said here already, so that a file cut short costs no memory: the whole of a plain file is known by its size.
  const double frames = double(v.info.frames) * v.info.components;
  const double wanted = double(v.offset) + double(v.info.geometry.voxel_count()) * v.stored.bytes * frames;
  const double most = v.path == header_path ? reader.most_bytes() : GzReader(v.path).most_bytes();
  if (wanted > most) throw_truncated(v.path, wanted, most);
  VolumeSource source;
  source.info = v.info;
  source.read = [v = std::move(v)] { return read_voxels(v); };
  return source;
}

}  // namespace simplexseg
