// SPDX-License-Identifier: Apache-2.0
#include "io/volume/minc.h"

#include <minc2.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/platform/worker_process.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr int kMaxMincAxes = 8;
constexpr std::size_t kBlockBytes = 32 << 20;  // largest block per call of libminc, at 8 bytes per voxel

/// Header of a file as sent by the worker process. Axes are in file order, the slowest first.
struct Description {
  char problem[120];  ///< reason why the file cannot be read; empty if it can
  int rank;
  std::array<std::uint64_t, kMaxMincAxes> sizes;
  std::array<int, kMaxMincAxes> kinds;  ///< values of midimclass_t
  std::array<std::array<double, 3>, kMaxMincAxes> cosines;
  std::array<double, kMaxMincAxes> steps, starts;
  bool uneven;  ///< the slice spacing is uneven
  int type;     ///< value of mitype_t
  bool scaled;  ///< the voxels are integers with a scale and an offset
};

void set_problem(Description& d, std::string_view text) {
  d.problem[text.copy(d.problem, sizeof d.problem - 1)] = '\0';
}

/// Throws std::runtime_error if a call of libminc failed.
void require(int status) {
  if (status != MI_NOERROR) throw std::runtime_error("its header is damaged");
}

void describe_axis(midimhandle_t dimension, std::size_t axis, Description& d) {
  midimclass_t kind = MI_DIMCLASS_ANY;
  misize_t size = 0;
  miboolean_t uneven = 0;
  require(miget_dimension_class(dimension, &kind));
  require(miget_dimension_size(dimension, &size));
  d.kinds[axis] = kind, d.sizes[axis] = size;
  if (kind != MI_DIMCLASS_SPATIAL) return;
  require(miget_dimension_separation(dimension, MI_ORDER_FILE, &d.steps[axis]));
  require(miget_dimension_start(dimension, MI_ORDER_FILE, &d.starts[axis]));
  require(miget_dimension_cosines(dimension, d.cosines[axis].data()));
  d.uneven = d.uneven || (miget_dimension_sampling_flag(dimension, &uneven) == MI_NOERROR && uneven);
}

mihandle_t describe(const fs::path& path, Description& d) {
  mihandle_t volume = nullptr;
  if (miopen_volume(path.c_str(), MI2_OPEN_READ, &volume) != MI_NOERROR || !volume)
    throw std::runtime_error("it is not a readable MINC file");
  require(miget_volume_dimension_count(volume, MI_DIMCLASS_ANY, MI_DIMATTR_ALL, &d.rank));
  if (d.rank < 1 || d.rank > kMaxMincAxes) require(MI_ERROR);
  std::array<midimhandle_t, kMaxMincAxes> dimensions{};
  if (miget_volume_dimensions(volume, MI_DIMCLASS_ANY, MI_DIMATTR_ALL, MI_DIMORDER_FILE, d.rank, dimensions.data()) < 0)
    require(MI_ERROR);
  for (std::size_t axis = 0; axis < static_cast<std::size_t>(d.rank); ++axis) describe_axis(dimensions[axis], axis, d);
  mitype_t type = MI_TYPE_UNKNOWN;
  require(miget_data_type(volume, &type));
  d.type = type;
  if (type == MI_TYPE_FLOAT || type == MI_TYPE_DOUBLE) return volume;
  miboolean_t by_slice = 0;
  require(miget_slice_scaling_flag(volume, &by_slice));
  double valid_max = 0, valid_min = 0, real_max = 0, real_min = 0;
  if (!by_slice) {
    require(miget_volume_valid_range(volume, &valid_max, &valid_min));
    require(miget_volume_range(volume, &real_max, &real_min));
  }
  d.scaled = by_slice || valid_max != real_max || valid_min != real_min;
  return volume;
}

/// Sends the description of the file through the pipe and, if `frame` is above 0, the voxels of the volume with that
/// number. Runs in the worker process.
void send_file(const fs::path& path, int frame, int pipe) {
  Description d{};
  mihandle_t volume = nullptr;
  try {
    volume = describe(path, d);
  } catch (const std::exception& exception) {
    set_problem(d, exception.what());
  }
  write_to_parent(pipe, &d, sizeof d);
  if (frame == 0 || !volume) return;
  const auto rank = static_cast<std::size_t>(d.rank);
  std::array<misize_t, kMaxMincAxes> start{}, count{};
  std::size_t slow = rank, slice_voxels = 1;  // the slowest spatial axis, and the voxels along the faster ones
  for (std::size_t axis = rank; axis-- > 0;) {
    const bool time = d.kinds[axis] == MI_DIMCLASS_TIME;
    start[axis] = time ? static_cast<misize_t>(frame - 1) : 0, count[axis] = time ? 1 : d.sizes[axis];
    if (time) continue;
    if (slow < rank) slice_voxels *= count[slow];
    slow = axis;
  }
  misize_t voxel_bytes = 0;
  miget_data_type_size(volume, &voxel_bytes);
  if (d.scaled) voxel_bytes = sizeof(float);
  const auto type = d.scaled ? MI_TYPE_FLOAT : static_cast<mitype_t>(d.type);
  const std::size_t at_once = std::max<std::size_t>(1, kBlockBytes / (slice_voxels * sizeof(double)));
  std::vector<char> block;
  for (std::size_t first = 0; first < d.sizes[slow]; first += at_once) {
    start[slow] = first, count[slow] = std::min<std::size_t>(at_once, d.sizes[slow] - first);
    block.resize(count[slow] * slice_voxels * voxel_bytes);
    require((d.scaled ? miget_real_value_hyperslab : miget_voxel_value_hyperslab)(volume, type, start.data(),
                                                                                  count.data(), block.data()));
    write_to_parent(pipe, block.data(), block.size());
  }
}

WorkerLimits limits_for(const fs::path& path, const VolumeInfo& info) {
  constexpr double min_mb_per_second = 10;  // far below the speed of decompression
  WorkerLimits limits;
  const auto slice = static_cast<std::size_t>(info.geometry.size[0]) * static_cast<std::size_t>(info.geometry.size[1]);
  limits.memory_bytes += 4 * std::max(kBlockBytes, slice * sizeof(double));
  const double bytes = static_cast<double>(fs::file_size(path)) +
                       static_cast<double>(info.geometry.voxel_count() * bytes_per_voxel(info.type));
  limits.cpu_seconds += static_cast<int>(std::min(bytes / (1e6 * min_mb_per_second), 1e6));
  return limits;
}

VoxelType type_of(const Description& d, const std::string& name) {
  if (d.scaled) return VoxelType::Float32;
  switch (d.type) {
    case MI_TYPE_BYTE:
      return VoxelType::Int8;
    case MI_TYPE_UBYTE:
      return VoxelType::UInt8;
    case MI_TYPE_SHORT:
      return VoxelType::Int16;
    case MI_TYPE_USHORT:
      return VoxelType::UInt16;
    case MI_TYPE_INT:
      return VoxelType::Int32;
    case MI_TYPE_UINT:
      return VoxelType::UInt32;
    case MI_TYPE_FLOAT:
      return VoxelType::Float32;
    case MI_TYPE_DOUBLE:
      return VoxelType::Float64;
    default:
      break;
  }
  throw Error("cannot read " + name, "its voxels have an unknown type",
              "save it with integer or floating-point voxels");
}

/// Converts a description. The fastest axis of the file becomes the first axis of the volume, and RAS becomes LPS.
VolumeInfo info_of(const Description& d, const std::string& name) {
  VolumeInfo info;
  info.format = "MINC";
  info.type = type_of(d, name);
  info.geometry.size = {1, 1, 1};
  int axis = 0;
  bool timed = false;
  Eigen::Vector3d origin_ras(0, 0, 0);
  for (std::size_t a = static_cast<std::size_t>(d.rank); a-- > 0;) {
    const auto size = static_cast<int>(std::min<std::uint64_t>(d.sizes[a], 1 << 30));
    if (d.kinds[a] == MI_DIMCLASS_SPATIAL && axis < 3) {
      const Eigen::Vector3d along(d.cosines[a][0], d.cosines[a][1], d.cosines[a][2]);
      info.geometry.size[static_cast<std::size_t>(axis)] = size;
      info.geometry.spacing_mm[axis] = std::abs(d.steps[a]);
      info.geometry.direction.col(axis) = kLpsFromRas.cwiseProduct(along.normalized()) * (d.steps[a] < 0 ? -1 : 1);
      origin_ras += d.starts[a] * along.normalized();
      ++axis;
    } else if (d.kinds[a] == MI_DIMCLASS_TIME && !timed) {
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
  if (d.uneven) info.warnings.push_back("the slice spacing is uneven; even spacing is assumed");
  return info;
}

/// Throws Error if the file is too small for its voxels. Volumes of up to `tolerated` voxels always pass, because MINC
/// 2 files may lack chunks that were never written.
void require_file_size(const fs::path& path, const Description& d) {
  constexpr double ratio = 1032, tolerated = 64e6;  // largest compression ratio of deflate; number of voxels
  double voxels = 1;
  for (int axis = 0; axis < d.rank; ++axis) voxels *= static_cast<double>(d.sizes[static_cast<std::size_t>(axis)]);
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
  const int frame = std::max(info.frame, 1);
  WorkerProcess worker(limits_for(path, info), [&](int pipe) { send_file(path, frame, pipe); });
  Volume volume(info.geometry, info.type);
  Description description{};
  auto* const to = static_cast<char*>(volume.data());
  bool complete = worker.read(&description, sizeof description);
  constexpr std::size_t block = 1 << 22;
  for (std::size_t done = 0; complete && done < volume.bytes(); done += block) {
    const std::size_t now = std::min(block, volume.bytes() - done);
    complete = worker.read(to + done, now);
    report_progress(static_cast<double>(done + now), static_cast<double>(volume.bytes()));
  }
  if (!complete)
    throw Error("cannot read " + quoted(path), "its voxels are damaged or incomplete", "copy or export the file again");
  return volume;
}

}  // namespace

VolumeSource open_minc(const fs::path& path, int volume) {
  require_file(path);
  if (!begins_like_minc(path))
    throw Error("cannot read " + quoted(path), "it is not a readable MINC file",
                "rename it with the extension of its format");
  Description d{};
  WorkerProcess worker(limits_for(path, {}), [&](int pipe) { send_file(path, 0, pipe); });
  if (!worker.read(&d, sizeof d)) set_problem(d, "it is damaged");
  if (d.problem[0] != '\0') throw Error("cannot read " + quoted(path), d.problem, "copy or export the file again");
  VolumeSource source;
  source.info = info_of(d, quoted(path));
  source.info.geometry.validate("cannot read " + quoted(path));
  require_file_size(path, d);
  warn_if_sheared(source.info);
  if (source.info.components == 1) select_volume(source.info, volume, "cannot read " + quoted(path));
  source.read = [info = source.info, path] { return read_minc(info, path); };
  return source;
}

}  // namespace simplexseg
