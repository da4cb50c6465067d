// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>

namespace simplexseg {

class Volume;
struct SimplexMesh;

/// What an object and its surroundings look like: counts over bins of intensity, the evidence of the region force.
/// Integers, so that summing them in any order gives the same bits.
inline constexpr int kRegionBins = 256;
struct RegionModel {
  double low = 0, high = 1;  ///< intensities of the first and the last bin
  std::array<std::int32_t, kRegionBins> object{};
  std::array<std::int32_t, kRegionBins> background{};
  bool empty() const;
};

/// The intensities that the bins of region models span: robust ends of the volume's histogram.
struct IntensityWindow {
  double low = 0, high = 1;
};
/// The 0.5% and 99.5% quantiles of the finite voxels, widened when they coincide. Samples at most a million voxels, on
/// a fixed lattice.
IntensityWindow intensity_window(const Volume& volume);

/// Object: the voxels inside of the mesh; background: those outside, up to `margin_mm` away from its bounding box. The
/// bins span what is usual among both, so that metal or air far from an organ's intensities cost no resolution.
RegionModel estimate_region(const Volume& volume, const SimplexMesh& mesh, double margin_mm);

/// log(p_object / p_background) of each bin, in [-1, 1], from histograms smoothed over bins; all 0 when the model is
/// empty.
std::array<float, kRegionBins> log_likelihood_ratios(const RegionModel& model);

}  // namespace simplexseg
