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
/// so that they do not depend on the order of the voxels.
struct RegionModel {
  double low = 0, high = 1;  ///< intensities at the centres of the first and the last bin
  std::array<std::int32_t, kRegionBins> object{};
  std::array<std::int32_t, kRegionBins> background{};
  bool empty() const;
};

/// Intensity range of a volume without outliers.
struct IntensityWindow {
  double low = 0, high = 1;
};
/// Window between the 0.5% and 99.5% quantiles of the finite voxels, widened if these nearly coincide; [0, 1] without a
/// finite voxel. Uses at most two million voxels, at a constant stride.
IntensityWindow intensity_window(const Volume& volume);

/// Estimates the region model of a mesh. Object: voxels inside the mesh. Background: voxels outside the mesh, in its
/// bounding box enlarged by `margin_mm`. The bins span the central quantiles of both and a margin, so that extreme
/// values such as metal or air do not reduce the resolution. Uses at most two million voxels of each, at a constant
/// stride. The model is empty if the mesh is, or if either has no finite voxel among these.
RegionModel estimate_region(const Volume& volume, const SimplexMesh& mesh, double margin_mm);

/// Log-likelihood ratio ln(p_object / p_background) of each bin from smoothed histograms, clamped to [-1, 1]; 0 in all
/// bins for an empty model.
std::array<float, kRegionBins> log_likelihood_ratios(const RegionModel& model);

}  // namespace simplexseg
