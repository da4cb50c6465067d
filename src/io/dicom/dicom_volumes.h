// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Volumes of one series.
struct DicomVolumes {
  std::vector<std::vector<DicomSlice>> volumes;  ///< sorted by the values of the distinguishing traits
  std::vector<std::string> names;                ///< one per volume, e.g. "echo time 20"; empty for a single volume
  std::string note;                              ///< warning about volumes of different positions; empty when none
};

/// Splits the slices of a series into volumes: by stack if the orientations differ, otherwise, if several slices
/// share a position (4D), by the first traits that yield volumes with identical positions. Passes over different
/// positions, i.e. stacks or acquisitions of at least three slices that are evenly spaced by themselves but not
/// together, are volumes too, with a note; unless the instance numbers show that slices between them are missing.
/// Otherwise all slices are one volume. Throws Error when every position has the same number of slices, more than
/// one, but no trait distinguishes the volumes; `series_name` is the name of the series in messages.
DicomVolumes split_volumes(std::vector<DicomSlice> slices, const std::string& series_name);

/// Time of each volume, s, if the volumes differ in a time of milliseconds alone: trigger time, trigger delay or frame
/// reference time; else empty.
std::vector<double> times_of(const DicomVolumes& volumes);

}  // namespace simplexseg
