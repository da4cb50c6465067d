// SPDX-License-Identifier: Apache-2.0
// Requests to the worker process that reads MINC files with libminc, and the functions that serve them. Functions of
// the namespace in_reader run in the worker process only, because libminc and HDF5 can crash, block and exhaust memory
// on damaged files.
#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <tuple>
#include <type_traits>
#include <vector>

#include "image/volume.h"
#include "io/platform/worker_request.h"

namespace simplexseg {

class ResponseWriter;

enum class MincAxisKind : std::uint8_t { Spatial, Time, Other };

struct MincAxis {
  MincAxisKind kind = MincAxisKind::Other;
  std::uint64_t size = 0;
  std::array<double, 3> cosines{};
  double step = 0, start = 0;
};

/// Header of a MINC file. Axes are in file order, the slowest first.
struct MincHeader {
  std::vector<MincAxis> axes;
  bool uneven = false;            ///< the slice spacing is uneven
  std::optional<VoxelType> type;  ///< stored type; nullopt when unknown
  bool scaled = false;            ///< the voxels are integers with a scale and an offset
};

template <class T>
requires std::same_as<std::remove_const_t<T>, MincAxis>
auto fields_of(T& axis) {
  auto& [kind, size, cosines, step, start] = axis;
  return std::tie(kind, size, cosines, step, start);
}
template <class T>
requires std::same_as<std::remove_const_t<T>, MincHeader>
auto fields_of(T& header) {
  auto& [axes, uneven, type, scaled] = header;
  return std::tie(axes, uneven, type, scaled);
}

inline constexpr RequestType<MincHeader> kMincHeader{"minc header"};
/// Voxels of the volume with a number from 1, as 32-bit floating-point numbers if they are scaled, otherwise in their
/// stored type.
inline constexpr RequestType<void, int> kMincVoxels{"minc voxels"};

constexpr std::size_t kMincBlockBytes = 32 << 20;  ///< largest block per call of libminc, at 8 bytes per voxel

namespace in_reader {

MincHeader describe_minc(const std::filesystem::path& path);
void read_minc_voxels(ResponseWriter& response, const std::filesystem::path& path, const int& number);

}  // namespace in_reader
}  // namespace simplexseg
