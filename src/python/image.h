// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "image/volume.h"

namespace simplexseg::python {

/// simplexseg.Volume: a volume and its source.
struct Image {
  Volume volume;
  std::filesystem::path path{};  ///< empty if the volume was created from an array
  int number = 1;                ///< number of the volume in a 4D file, counted from 1
  std::string series{};          ///< UID of the series in a DICOM folder; empty: the largest series
  bool low_is_bright = false;    ///< low values are displayed bright (MONOCHROME1)
};

}  // namespace simplexseg::python
