// SPDX-License-Identifier: Apache-2.0
#include "io/volume/minc.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>

#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/volume/minc_requests.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

WorkerLimits minc_limits(const fs::path& path, const VolumeInfo& info) {
  constexpr double min_mb_per_second = 10;  // far below the speed of decompression
  WorkerLimits limits;
  const auto slice = static_cast<std::size_t>(info.geometry.size[0]) * static_cast<std::size_t>(info.geometry.size[1]);
  limits.memory_bytes += 4 * std::max(kMincBlockBytes, slice * sizeof(double));
  const double bytes = static_cast<double>(fs::file_size(path)) +
                       static_cast<double>(info.geometry.voxel_count() * bytes_per_voxel(info.type));
  limits.cpu_seconds += static_cast<int>(std::min(bytes / (1e6 * min_mb_per_second), 1e6));
  return limits;
}

VoxelType minc_type(const MincHeader& header, const std::string& name) {
  if (header.scaled) return VoxelType::Float32;
  if (header.type) return *header.type;
  throw Error("cannot read " + name, "its voxels have an unknown type",
              "save it with integer or floating-point voxels");
}

/// Converts a header. The fastest axis of the file becomes the first axis of the volume, and RAS becomes LPS.
VolumeInfo info_of(const MincHeader& header, const std::string& name) {
  VolumeInfo info;
  info.format = "MINC";
  info.type = minc_type(header, name);
  info.geometry.size = {1, 1, 1};
  int axis = 0;
  bool timed = false;
  Eigen::Vector3d origin_ras(0, 0, 0);
  for (std::size_t a = header.axes.size(); a-- > 0;) {
    const MincAxis& stored = header.axes[a];
    const auto size = static_cast<int>(std::min<std::uint64_t>(stored.size, 1 << 30));
    if (stored.kind == MincAxisKind::Spatial && axis < 3) {
      const Eigen::Vector3d along(stored.cosines[0], stored.cosines[1], stored.cosines[2]);
      info.geometry.size[static_cast<std::size_t>(axis)] = size;
      info.geometry.spacing_mm[axis] = std::abs(stored.step);
      info.geometry.direction.col(axis) = kLpsFromRas.cwiseProduct(along.normalized()) * (stored.step < 0 ? -1 : 1);
      origin_ras += stored.start * along.normalized();
      ++axis;
    } else if (stored.kind == MincAxisKind::Time && !timed) {
      timed = true;
      info.frames = size;
    } else {
      info.components = static_cast<int>(std::min(1.0 * info.components * size, 1e9));
    }
  }
  if (axis < 2) throw Error("cannot read " + name, "it has fewer than two spatial axes", "export it as a volume");
  if (axis == 2)
    info.geometry.direction.col(2) = info.geometry.direction.col(0).cross(info.geometry.direction.col(1)).normalized();
  info.geometry.origin_mm = kLpsFromRas.cwiseProduct(origin_ras);
  if (header.uneven) info.warnings.push_back("the slice spacing is uneven; even spacing is assumed");
  return info;
}

/// Throws Error if the file is too small for its voxels. Volumes of up to `tolerated` voxels always pass, because MINC
/// 2 files may lack chunks that were never written.
void require_file_size(const fs::path& path, const MincHeader& header) {
  constexpr double ratio = 1032, tolerated = 64e6;  // largest compression ratio of deflate; number of voxels
  double voxels = 1;
  for (const MincAxis& axis : header.axes) voxels *= static_cast<double>(axis.size);
  const double max_voxels = ratio * double(fs::file_size(path));
  if (voxels > std::max(max_voxels, tolerated)) throw_truncated(path, voxels, max_voxels);
}

/// Whether the file has the magic number of HDF5 (MINC 2) or netCDF (MINC 1).
bool begins_like_minc(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  char magic[4] = {};
  return stream.read(magic, 4) && (std::memcmp(magic, "\x89HDF", 4) == 0 || std::memcmp(magic, "CDF", 3) == 0);
}

Volume read_minc(const VolumeInfo& info, const fs::path& path) {
  Volume volume(info.geometry, info.type);
  auto* const to = static_cast<char*>(volume.data());
  try {
    WorkerRequest request(packed_request(kMincVoxels, path, std::max(info.frame, 1)), path, minc_limits(path, info));
    constexpr std::size_t block = 1 << 22;
    for (std::size_t done = 0; done < volume.bytes(); done += block) {
      const std::size_t now = std::min(block, volume.bytes() - done);
      request.read(to + done, now);
      report_progress(static_cast<double>(done + now), static_cast<double>(volume.bytes()));
    }
    request.finish();
  } catch (const WorkerFailure&) {
    throw Error("cannot read " + quoted(path), "its voxels are damaged or incomplete", "copy or export the file again");
  }
  return volume;
}

/// Requests the header. Throws Error when it cannot be read.
MincHeader read_header(const fs::path& path) {
  constexpr std::size_t max_axes = 8;
  try {
    MincHeader header = request_result(kMincHeader, path, minc_limits(path, {}));
    if (header.axes.size() > max_axes || (header.type && *header.type > VoxelType::Float64))
      throw WorkerFailure("it is damaged");
    return header;
  } catch (const WorkerFailure& failure) {
    throw Error("cannot read " + quoted(path), failure.what(), "copy or export the file again");
  }
}

}  // namespace

VolumeSource open_minc(const fs::path& path, int volume) {
  require_file(path);
  if (!begins_like_minc(path))
    throw Error("cannot read " + quoted(path), "it is not a readable MINC file",
                "rename it with the extension of its format");
  const MincHeader header = read_header(path);
  VolumeSource source;
  source.info = info_of(header, quoted(path));
  source.info.geometry.validate("cannot read " + quoted(path));
  require_file_size(path, header);
  warn_if_sheared(source.info);
  if (source.info.components == 1) select_volume(source.info, volume, "cannot read " + quoted(path));
  source.read = [info = source.info, path] { return read_minc(info, path); };
  return source;
}

}  // namespace simplexseg
