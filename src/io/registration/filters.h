// SPDX-License-Identifier: Apache-2.0
// Filters of ITK, in the worker process simplexseg-register (docs/adr/0059-filters.md).
#pragma once
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

enum class FilterKind : std::uint8_t { BiasField, Diffusion, Median, Isotropic };

/// Parameter of a filter.
struct FilterParameter {
  const char* name;
  double value, min, max;  ///< default and range
  bool integer;
  const char* help;  ///< meaning, with unit
};

/// Name of a filter and its parameters.
struct FilterInfo {
  FilterKind kind;
  const char* name;  ///< as an option: --n4
  const char* help;
  std::span<const FilterParameter> parameters;
  bool keeps_type;  ///< the result has the voxel type of the image, else Float32
};

/// All filters, in the order of FilterKind.
std::span<const FilterInfo> filter_list();
const FilterInfo& info_of(FilterKind kind);
/// Default values of the parameters of a filter.
std::vector<double> default_parameters(FilterKind kind);

/// Result of a filter on a volume; the grid differs from that of the volume only for Isotropic. `parameters`: in the
/// order of FilterInfo::parameters; `threads`: number of threads, 0 for all cores, which changes no bit of the result;
/// `on_progress` receives the share of the work that is done. Voxels that are not finite count as the smallest finite
/// value. Throws Error for parameters out of range, an image that has no foreground (BiasField), a result that is too
/// large, a missing worker program, or one that was killed; throws Cancelled after a cancellation of the bound
/// LoadProgress.
Volume filter_volume(const Volume& volume, FilterKind kind, const std::vector<double>& parameters, int threads = 0,
                     const std::function<void(double)>& on_progress = {});

}  // namespace simplexseg
