// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Volumes of one series.
struct DicomVolumes {
  std::vector<std::vector<DicomSlice>> volumes;  ///< sorted by the distinguishing traits
  std::vector<std::string> names;                ///< e.g. "echo time 20"; empty for a single volume
};

/// Splits the slices of a series into volumes if several slices share a position (4D) or if its stacks differ in
/// orientation; otherwise all slices are one volume. Uses the first traits that yield volumes with identical positions.
/// Throws Error when every position has the same number of slices but no trait distinguishes the volumes;
/// `series_name` is the name of the series.
DicomVolumes split_volumes(std::vector<DicomSlice> slices, const std::string& series_name);

}  // namespace simplexseg
