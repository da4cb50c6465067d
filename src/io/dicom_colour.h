// SPDX-License-Identifier: Apache-2.0
// Colours as DICOM keeps them: CIELab under D50, each part in 16 bits (PS3.3 C.10.7.1.1).
#pragma once
#include <array>
#include <cstdint>

#include "core/colour.h"

namespace simplexseg {

/// L from 0 to 100, a and b from -128 to 127, each stretched over 0 to 65535.
using DicomLab = std::array<std::uint16_t, 3>;

/// As sRGB; what lies beyond its colours takes the nearest value of each channel.
Colour colour_of_lab(const DicomLab& lab);
/// The inverse: colour_of_lab() gives every colour back.
DicomLab lab_of_colour(const Colour& colour);

}  // namespace simplexseg
