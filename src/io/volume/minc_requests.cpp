// SPDX-License-Identifier: Apache-2.0
#include "io/volume/minc_requests.h"

#include <minc2.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "io/platform/worker_channel.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxMincAxes = 8;

/// Open volume of libminc.
class MincFile {
 public:
  explicit MincFile(const std::filesystem::path& path) {
    if (miopen_volume(path.c_str(), MI2_OPEN_READ, &volume_) != MI_NOERROR || !volume_)
      throw std::runtime_error("it is not a readable MINC file");
  }
  ~MincFile() { miclose_volume(volume_); }
  MincFile(const MincFile&) = delete;
  MincFile& operator=(const MincFile&) = delete;
  mihandle_t handle() const { return volume_; }

 private:
  mihandle_t volume_ = nullptr;
};

/// Throws std::runtime_error if a call of libminc failed.
void require_success(int status) {
  if (status != MI_NOERROR) throw std::runtime_error("its header is damaged");
}

MincAxis describe_axis(midimhandle_t dimension, bool& uneven) {
  midimclass_t kind = MI_DIMCLASS_ANY;
  misize_t size = 0;
  miboolean_t is_uneven = 0;
  MincAxis axis;
  require_success(miget_dimension_class(dimension, &kind));
  require_success(miget_dimension_size(dimension, &size));
  axis.size = size;
  axis.kind = kind == MI_DIMCLASS_SPATIAL ? MincAxisKind::Spatial
              : kind == MI_DIMCLASS_TIME  ? MincAxisKind::Time
                                          : MincAxisKind::Other;
  if (axis.kind != MincAxisKind::Spatial) return axis;
  require_success(miget_dimension_separation(dimension, MI_ORDER_FILE, &axis.step));
  require_success(miget_dimension_start(dimension, MI_ORDER_FILE, &axis.start));
  require_success(miget_dimension_cosines(dimension, axis.cosines.data()));
  uneven = uneven || (miget_dimension_sampling_flag(dimension, &is_uneven) == MI_NOERROR && is_uneven);
  return axis;
}

std::optional<VoxelType> voxel_type_of_minc(mitype_t type) {
  switch (type) {
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
      return std::nullopt;
  }
}

MincHeader describe_volume(mihandle_t volume) {
  MincHeader header;
  int rank = 0;
  require_success(miget_volume_dimension_count(volume, MI_DIMCLASS_ANY, MI_DIMATTR_ALL, &rank));
  if (rank < 1 || rank > static_cast<int>(kMaxMincAxes)) require_success(MI_ERROR);
  std::array<midimhandle_t, kMaxMincAxes> dimensions{};
  if (miget_volume_dimensions(volume, MI_DIMCLASS_ANY, MI_DIMATTR_ALL, MI_DIMORDER_FILE, rank, dimensions.data()) < 0)
    require_success(MI_ERROR);
  for (int axis = 0; axis < rank; ++axis)
    header.axes.push_back(describe_axis(dimensions[static_cast<std::size_t>(axis)], header.uneven));
  mitype_t type = MI_TYPE_UNKNOWN;
  require_success(miget_data_type(volume, &type));
  header.type = voxel_type_of_minc(type);
  if (type == MI_TYPE_FLOAT || type == MI_TYPE_DOUBLE) return header;
  miboolean_t by_slice = 0;
  require_success(miget_slice_scaling_flag(volume, &by_slice));
  double valid_max = 0, valid_min = 0, real_max = 0, real_min = 0;
  if (!by_slice) {
    require_success(miget_volume_valid_range(volume, &valid_max, &valid_min));
    require_success(miget_volume_range(volume, &real_max, &real_min));
  }
  header.scaled = by_slice || valid_max != real_max || valid_min != real_min;
  return header;
}

}  // namespace

MincHeader in_reader::describe_minc(const std::filesystem::path& path) {
  return describe_volume(MincFile(path).handle());
}

void in_reader::read_minc_voxels(ResponseWriter& response, const std::filesystem::path& path, const int& number) {
  const MincFile file(path);
  const MincHeader header = describe_volume(file.handle());
  const std::size_t rank = header.axes.size();
  std::array<misize_t, kMaxMincAxes> start{}, count{};
  std::size_t slow = rank, slice_voxels = 1;  // the slowest spatial axis, and the voxels along the faster ones
  for (std::size_t axis = rank; axis-- > 0;) {
    const bool time = header.axes[axis].kind == MincAxisKind::Time;
    start[axis] = time ? static_cast<misize_t>(number - 1) : 0, count[axis] = time ? 1 : header.axes[axis].size;
    if (time) continue;
    if (slow < rank) slice_voxels *= count[slow];
    slow = axis;
  }
  if (slow == rank) throw std::runtime_error("it has no spatial axis");
  mitype_t type = MI_TYPE_FLOAT;
  misize_t voxel_bytes = sizeof(float);
  if (!header.scaled) {
    require_success(miget_data_type(file.handle(), &type));
    require_success(miget_data_type_size(file.handle(), &voxel_bytes));
  }
  const auto read = header.scaled ? miget_real_value_hyperslab : miget_voxel_value_hyperslab;
  const std::size_t at_once = std::max<std::size_t>(1, kMincBlockBytes / (slice_voxels * sizeof(double)));
  std::vector<char> block;
  for (std::size_t first = 0; first < header.axes[slow].size; first += at_once) {
    start[slow] = first, count[slow] = std::min<std::size_t>(at_once, header.axes[slow].size - first);
    block.resize(count[slow] * slice_voxels * voxel_bytes);
    require_success(read(file.handle(), type, start.data(), count.data(), block.data()));
    response.data(block.data(), block.size());
  }
}

}  // namespace simplexseg
