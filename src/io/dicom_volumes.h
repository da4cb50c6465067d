// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "io/dicom_slice.h"

namespace simplexseg {

/// The volumes of one series.
struct DicomVolumes {
  std::vector<std::vector<DicomSlice>> volumes;  ///< in the order of what tells them apart
  std::vector<std::string> names;                ///< "echo time 20"; one for each volume where there are several
};

/// Splits slices of one series, where several lie at one place (4D) or their stacks have different orientations, by the
/// traits that make volumes of the same places of them; else all of them are one volume. Throws Error, with `what`
/// naming the series, when each place holds the same number of slices and no trait tells their volumes apart.
DicomVolumes split_volumes(std::vector<DicomSlice> slices, const std::string& what);

}  // namespace simplexseg
