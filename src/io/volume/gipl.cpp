// SPDX-License-Identifier: Apache-2.0
#include "io/volume/gipl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "io/platform/decompressing_reader.h"
#include "io/platform/files.h"
#include "io/source/stored_voxels.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kHeaderBytes = 256;

/// Header of a GIPL file. All numbers in it are big-endian.
struct GiplHeader {
  std::array<unsigned char, kHeaderBytes> bytes{};

  template <class T>
  T at(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw;
    std::memcpy(raw.data(), &bytes[offset], sizeof(T));
    std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  bool is_gipl() const {
    const auto number = at<std::uint32_t>(252);
    return number == 719555000u || number == 4026526128u;
  }
};

GiplHeader read_header(DecompressingReader& reader) {
  GiplHeader header;
  if (reader.read(header.bytes.data(), kHeaderBytes) != kHeaderBytes) header = {};
  return header;
}

StoredType type_of(int code, const std::string& name) {
  switch (code) {
    case 7:
      return {1, VoxelType::Int8};
    case 8:
      return {1, VoxelType::UInt8};
    case 15:
      return {2, VoxelType::Int16};
    case 16:
      return {2, VoxelType::UInt16};
    case 31:
      return {4, VoxelType::UInt32};
    case 32:
      return {4, VoxelType::Int32};
    case 64:
      return {4, VoxelType::Float32};
    case 65:
      return {8, VoxelType::Float64};
    default:
      break;
  }
  throw Error("cannot read " + name, "its voxels have an unknown type (code " + std::to_string(code) + ")",
              "save it with integer or floating-point voxels");
}

}  // namespace

bool is_gipl_file(const fs::path& path) {
  DecompressingReader reader(path);
  return read_header(reader).is_gipl();
}

VolumeSource open_gipl(const fs::path& path, int volume) {
  DecompressingReader reader(path);
  const GiplHeader header = read_header(reader);
  const std::string name = quoted(path);
  if (!header.is_gipl()) {
    throw Error("cannot read " + name, "it does not begin with a GIPL header",
                "rename it with the extension of its format");
  }
  VolumeInfo info;
  info.format = "GIPL";
  for (std::size_t a = 0; a < 4; ++a) {
    const int size = std::max<int>(1, header.at<std::uint16_t>(2 * a));  // 0: absent axis
    if (a == 3) info.frames = size;
    if (a == 3) break;
    const int axis = static_cast<int>(a);
    info.geometry.size[a] = size;
    const double step = header.at<float>(10 + 4 * a);
    info.geometry.set_step(axis, size == 1 && step == 0 ? 1 : step);
    info.geometry.origin_mm[axis] = header.at<double>(204 + 8 * a);
  }
  info.warnings.push_back("GIPL files contain no orientation: the patient's left and right are unknown");
  StoredVoxels voxels;
  voxels.files = {path};
  voxels.skipped = kHeaderBytes;
  voxels.compression = reader.is_compressed() ? Compression::Deflate : Compression::None;
  voxels.swapped = true;
  voxels.type = type_of(header.at<std::uint16_t>(8), name);
  return open_stored(std::move(info), std::move(voxels), path, volume);
}

}  // namespace simplexseg
