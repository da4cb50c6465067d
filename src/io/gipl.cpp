// SPDX-License-Identifier: Apache-2.0
#include "io/gipl.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

#include "io/files.h"
#include "io/packed_reader.h"
#include "io/stored_voxels.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kHeaderBytes = 256;

/// All numbers of the file are big-endian.
struct Header {
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

Header read_header(PackedReader& reader) {
  Header header;
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
  throw Error("cannot read " + name, "its voxels are of a type that is not known (code " + std::to_string(code) + ")",
              "save it as integers or floats");
}

}  // namespace

bool looks_like_gipl(const fs::path& path) {
  PackedReader reader(path);
  return read_header(reader).is_gipl();
}

VolumeSource open_gipl(const fs::path& path, int volume) {
  PackedReader reader(path);
  const Header header = read_header(reader);
  const std::string name = quoted(path);
  if (!header.is_gipl()) {
    throw Error("cannot read " + name, "it does not begin with a GIPL header",
                "give it the extension of its real format, or export it again");
  }
  VolumeInfo info;
  info.format = "GIPL";
  for (std::size_t a = 0; a < 4; ++a) {
    const int size = std::max<int>(1, header.at<std::uint16_t>(2 * a));  // 0: an axis that is not there
    if (a == 3) info.frames = size;
    if (a == 3) break;
    const int axis = static_cast<int>(a);
    info.geometry.size[a] = size;
    info.geometry.spacing_mm[axis] = header.at<float>(10 + 4 * a);
    info.geometry.origin_mm[axis] = header.at<double>(204 + 8 * a);
    if (size == 1 && info.geometry.spacing_mm[axis] == 0) info.geometry.spacing_mm[axis] = 1;
  }
  info.warnings.push_back("GIPL gives no orientation: which side is the patient's left is not known");
  StoredVoxels voxels;
  voxels.files = {path};
  voxels.skipped = kHeaderBytes;
  voxels.packing = reader.packed() ? Packing::Deflate : Packing::None;
  voxels.swapped = true;
  voxels.type = type_of(header.at<std::uint16_t>(8), name);
  return open_stored(std::move(info), std::move(voxels), path, volume);
}

}  // namespace simplexseg
