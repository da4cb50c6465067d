// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>

namespace simplexseg {

class Volume;
struct SimplexMesh;

/// Number of intensity bins of a region model.
inline constexpr int kRegionBins = 256;
/// Intensity histograms of an object and its surroundings, for the evidence from intensities. The counts are integers,
/// so that sums do not depend on the order.
struct RegionModel {
  double low = 0, high = 1;  ///< intensities of the first and the last bin
  std::array<std::int32_t, kRegionBins> object{};
  std::array<std::int32_t, kRegionBins> background{};
  bool empty() const;
};

/// Robust intensity range of a volume.
struct IntensityWindow {
  double low = 0, high = 1;
};
/// Window between the 0.5% and 99.5% quantiles of the finite voxels, widened if they coincide. Uses a fixed lattice of
/// at most two million voxels.
IntensityWindow intensity_window(const Volume& volume);

/// Estimates the region model of a mesh. Object: voxels inside the mesh; background: voxels outside, up to `margin_mm`
/// from its bounding box. The bins span the central quantiles of both, so that extreme values such as metal or air
/// do not reduce the resolution.
RegionModel estimate_region(const Volume& volume, const SimplexMesh& mesh, double margin_mm);

/// log(p_object / p_background) of each bin, clamped to [-1, 1], from smoothed histograms; all 0 for an empty model.
std::array<float, kRegionBins> log_likelihood_ratios(const RegionModel& model);

}  // namespace simplexseg
