// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

#include "image/volume.h"

namespace simplexseg::python {

/// simplexseg.Volume: a volume, and where it was read from.
struct Image {
  Volume volume;
  std::filesystem::path path{};  ///< empty where it was made of an array
  int number = 1;                ///< which volume of a 4D file
  std::string series{};          ///< UID of the series of a DICOM folder; empty: the largest
  bool low_is_bright = false;    ///< low values are meant to be shown bright (MONOCHROME1)
};

}  // namespace simplexseg::python
