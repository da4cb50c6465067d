// SPDX-License-Identifier: Apache-2.0
#include "image/contrast_range.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

namespace simplexseg {

Volume::Range contrast_range(const Volume& volume) {
  constexpr std::size_t kSamples = 200000;
  std::vector<float> values;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    // The stride is odd, because otherwise all samples might lie in one column.
    const std::size_t stride = voxels.size() / kSamples | 1;
    for (std::size_t n = 0; n < voxels.size(); n += stride) {
      const float value = static_cast<float>(voxels[n]);
      if (std::isfinite(value)) values.push_back(value);
    }
  });
  if (values.empty()) return {0, 1};
  std::sort(values.begin(), values.end());
  // Air (-1000) and bone (above 300) indicate Hounsfield units: window 400, level 40 are usual for soft tissue.
  if (values[values.size() / 20] <= -900 && values.back() >= 300 && values.back() <= 40000) return {-160, 240};
  // Voxels of the lowest value (air, padding) often fill most of a volume; the upper percentile excludes them.
  const auto first = std::upper_bound(values.begin(), values.end(), values.front());
  const auto count = values.end() - first;
  const double low = values[values.size() / 100];
  const double high = count == 0 ? values.back() : *(first + static_cast<std::ptrdiff_t>(0.995 * (count - 1)));
  return high > low ? Volume::Range{low, high} : Volume::Range{low - 0.5, low + 0.5};
}

}  // namespace simplexseg
