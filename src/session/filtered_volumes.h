// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <map>
#include <span>
#include <string>
#include <vector>

#include "image/preprocessing.h"
#include "image/volume.h"

namespace simplexseg {

/// Result of filters on the volume of a scene; without filters the volume itself.
struct FilteredVolume {
  std::vector<FilterStep> filters;
  Volume volume;
};

/// Results of filters on the volume of a scene that are in memory. Copies share the voxels.
class FilteredVolumes {
 public:
  /// Sets the function that computes missing results; without it, they are refused.
  void set_filter(ApplyFilter apply) { apply_ = std::move(apply); }
  /// Discards all results and adds that of the filters of a scene.
  void open(const std::vector<FilterStep>& filters, const Volume& volume);
  /// Adds a result. Throws Error if its grid is not that of the others.
  void add(FilteredVolume result);
  /// Result of filters, which is computed if it is missing. Throws Error if that is not possible.
  const Volume& get(const std::vector<FilterStep>& filters);

 private:
  ApplyFilter apply_;
  std::map<std::string, Volume> by_key_;  ///< key: key_of()
};

/// Throws Error for filters that the volume of a scene cannot have, because marks, paint and labels have its grid.
void check_volume_filters(const Preprocessing& preprocessing);

}  // namespace simplexseg
