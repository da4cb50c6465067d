// SPDX-License-Identifier: Apache-2.0
// Colours in DICOM: CIELab under D50 with 16 bits per component (PS3.3 C.10.7.1.1).
#pragma once
#include <array>
#include <cstdint>

#include "core/colour.h"

namespace simplexseg {

/// L* (0 to 100), a* and b* (-128 to 127), each scaled to 0 to 65535.
using DicomLab = std::array<std::uint16_t, 3>;

/// Converts to sRGB; each channel is clamped to its range.
Colour colour_of_lab(const DicomLab& lab);
/// Converts from sRGB; colour_of_lab() returns exactly the original colour.
DicomLab lab_of_colour(const Colour& colour);

}  // namespace simplexseg
