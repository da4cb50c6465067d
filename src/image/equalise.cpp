// SPDX-License-Identifier: Apache-2.0
#include "image/equalise.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace simplexseg {
namespace {

constexpr std::size_t kMaxSamples = 1000000;
constexpr double kLargest = 65535;

}  // namespace

Volume equalised(const Volume& volume) {
  Volume result(volume.geometry(), VoxelType::UInt16);
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    const std::size_t step = std::max<std::size_t>(1, voxels.size() / kMaxSamples);
    std::vector<T> samples;
    for (std::size_t v = 0; v < voxels.size(); v += step)
      if (std::isfinite(static_cast<double>(voxels[v]))) samples.push_back(voxels[v]);
    std::ranges::sort(samples);
    if (samples.empty()) return;
    const std::span<std::uint16_t> ranks = result.voxels<std::uint16_t>();
    const auto rank_of = [&](T value) {
      const auto below = std::ranges::lower_bound(samples, value) - samples.begin();
      return static_cast<std::uint16_t>(
          std::lround(kLargest * static_cast<double>(below) / static_cast<double>(samples.size())));
    };
    if constexpr (sizeof(T) <= 2) {  // each value is searched once
      constexpr int kFirst = std::numeric_limits<T>::min(), kLast = std::numeric_limits<T>::max();
      std::vector<std::uint16_t> table;
      for (int value = kFirst; value <= kLast; ++value) table.push_back(rank_of(static_cast<T>(value)));
      for (std::size_t v = 0; v < voxels.size(); ++v) ranks[v] = table[static_cast<std::size_t>(voxels[v] - kFirst)];
    } else {
      for (std::size_t v = 0; v < voxels.size(); ++v)
        if (std::isfinite(static_cast<double>(voxels[v]))) ranks[v] = rank_of(voxels[v]);
    }
  });
  return result;
}

}  // namespace simplexseg
