// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nifti_header.h"

#include <cmath>
#include <limits>

#include "core/error.h"

namespace simplexseg {
namespace {

/// Header fields as numbers; version -1 if the bytes are neither NIfTI nor Analyze.
NiftiHeader parse(const std::array<unsigned char, 540>& bytes, std::size_t count) {
  NiftiHeader h;
  h.bytes = bytes;
  h.version = -1;
  if (count < 348) return h;
  const auto has_magic = [&](std::size_t at, const char* magic) { return std::memcmp(&bytes[at], magic, 4) == 0; };
  for (const bool swapped : {false, true}) {
    h.swapped = swapped;
    const auto size = h.at<std::int32_t>(0);
    if (size == 540 && count >= 540 && (has_magic(4, "n+2\0") || has_magic(4, "ni2\0"))) {
      h.version = 2;
      h.single_file = bytes[5] == '+';
      break;
    }
    const bool nifti = has_magic(344, "n+1\0") || has_magic(344, "ni1\0");
    const auto rank = h.at<std::int16_t>(40);
    if (nifti ? rank >= 1 && rank <= 7 : size == 348) {
      h.version = nifti ? 1 : 0;
      h.single_file = nifti && bytes[345] == '+';
      break;
    }
  }
  if (h.version < 0) return h;
  std::array<double, 12> rows{};
  if (h.version == 2) {
    h.datatype = h.at<std::int16_t>(12);
    h.fill<std::int64_t>(h.dim, 16, 8);
    h.fill<double>(h.pixdim, 104, 8);
    h.vox_offset = static_cast<double>(h.at<std::int64_t>(168));
    h.slope = h.at<double>(176);
    h.intercept = h.at<double>(184);
    h.qform_code = h.at<std::int32_t>(344);
    h.sform_code = h.at<std::int32_t>(348);
    h.fill<double>(h.quaternion, 352, 3);
    h.fill<double>(h.qoffset, 376, 3);
    h.fill<double>(rows, 400, 12);
    h.units = h.at<std::int32_t>(500);
  } else {
    h.datatype = h.at<std::int16_t>(70);
    h.fill<std::int16_t>(h.dim, 40, 8);
    h.fill<float>(h.pixdim, 76, 8);
    h.vox_offset = h.at<float>(108);
    if (h.version == 1) {
      h.slope = h.at<float>(112);
      h.intercept = h.at<float>(116);
      h.qform_code = h.at<std::int16_t>(252);
      h.sform_code = h.at<std::int16_t>(254);
      h.fill<float>(h.quaternion, 256, 3);
      h.fill<float>(h.qoffset, 268, 3);
      h.fill<float>(rows, 280, 12);
      h.units = h.at<std::uint8_t>(123);
    }
  }
  h.srow = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(rows.data());
  return h;
}

}  // namespace

NiftiHeader read_nifti_header(DecompressingReader& reader) {
  constexpr std::size_t kBytesOfVersion1 = 348, kBytesOfVersion2 = 540;
  std::array<unsigned char, kBytesOfVersion2> bytes{};
  if (reader.read(bytes.data(), kBytesOfVersion1) != kBytesOfVersion1) return parse(bytes, 0);
  std::size_t count = kBytesOfVersion1;
  if (std::memcmp(&bytes[4], "n+2", 3) == 0 || std::memcmp(&bytes[4], "ni2", 3) == 0)
    count += reader.read(&bytes[count], kBytesOfVersion2 - kBytesOfVersion1);
  return parse(bytes, count);
}

StoredType stored_type(int datatype, const std::string& name) {
  switch (datatype) {
    case 2:
      return {1, VoxelType::UInt8};
    case 4:
      return {2, VoxelType::Int16};
    case 8:
      return {4, VoxelType::Int32};
    case 16:
      return {4, VoxelType::Float32};
    case 64:
      return {8, VoxelType::Float64};
    case 256:
      return {1, VoxelType::Int8};
    case 512:
      return {2, VoxelType::UInt16};
    case 768:
      return {4, VoxelType::UInt32};
    case 1024:
      return {8, VoxelType::Int32, true};
    case 1280:
      return {8, VoxelType::UInt32, true};
    default:
      break;
  }
  const char* kind = "of an unknown type (code ";
  if (datatype == 128 || datatype == 2304) kind = "colours (code ";
  if (datatype == 32 || datatype == 1792 || datatype == 2048) kind = "complex numbers (code ";
  if (datatype == 1) kind = "single bits (code ";
  if (datatype == 1536) kind = "128-bit numbers (code ";
  throw Error("cannot read " + name, std::string("its voxels are ") + kind + std::to_string(datatype) + ")",
              "save it with one integer or float per voxel");
}

namespace {

/// Times of the volumes, if the header states their interval in a unit of time.
std::vector<double> times_of(const NiftiHeader& h, int frames) {
  constexpr int kMaxTimes = 100000;
  constexpr int kTimeUnits = 0x38;  // bits of the field for units that contain the unit of time
  const int unit = h.units & kTimeUnits;
  const double seconds = unit == 8 ? 1 : unit == 16 ? 1e-3 : unit == 24 ? 1e-6 : 0, interval = h.pixdim[4] * seconds;
  std::vector<double> times;
  if (h.version < 1 || frames < 2 || frames > kMaxTimes || frames != h.dim[4]) return times;
  if (!std::isfinite(interval) || interval <= 0) return times;
  for (int frame = 0; frame < frames; ++frame) times.push_back(frame * interval);
  return times;
}

}  // namespace

void set_sizes(const NiftiHeader& h, VolumeInfo& info, const std::string& name) {
  const std::int64_t rank = h.dim[0];
  if (rank < 1 || rank > 7) {
    throw Error("cannot read " + name, "its header claims " + std::to_string(rank) + " dimensions",
                "copy or export the file again");
  }
  double extra[2] = {1, 1};  // frames, components
  for (int a = 1; a <= rank; ++a) {
    const std::int64_t size = h.dim[a];
    if (size < 1 || size > std::numeric_limits<int>::max()) {
      throw Error("cannot read " + name,
                  "its header claims " + std::to_string(size) + " voxels along axis " + std::to_string(a),
                  "copy or export the file again");
    }
    if (a > 3) extra[a == 5] *= static_cast<double>(size);
  }
  for (int a = 0; a < 3; ++a) info.geometry.size[a] = a < rank ? static_cast<int>(h.dim[a + 1]) : 1;
  info.frames = static_cast<int>(std::min(extra[0], 1e9));
  info.components = static_cast<int>(std::min(extra[1], 1e9));
  info.times_s = times_of(h, info.frames);
}

}  // namespace simplexseg
