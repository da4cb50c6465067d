// SPDX-License-Identifier: Apache-2.0
// Filters of images: those of ITK in the worker process simplexseg-register (docs/adr/0059-filters.md), and uptake
// values.
#pragma once
#include <functional>
#include <vector>

#include "image/preprocessing.h"

namespace simplexseg {

/// Result of a filter on a volume; the grid differs from that of the volume only for Isotropic. `parameters`: in the
/// order of FilterInfo::parameters; `threads`: number of threads, 0 for all cores, which changes no bit of the result;
/// `on_progress` receives the share of the work that is done. Voxels that are not finite count as the smallest finite
/// value. Throws Error for parameters out of range, an image that has no foreground (BiasField), a result that is too
/// large, a missing worker program, or one that was killed; throws Cancelled after a cancellation of the bound
/// LoadProgress.
Volume filter_volume(const Volume& volume, FilterKind kind, const std::vector<double>& parameters, int threads = 0,
                     const std::function<void(double)>& on_progress = {});
/// Result of one step, with all cores. Reports to the bound LoadProgress.
Volume filter_volume(const Volume& volume, const FilterStep& step);

}  // namespace simplexseg
