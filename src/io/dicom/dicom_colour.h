// SPDX-License-Identifier: Apache-2.0
// Colours in DICOM: CIELab with white point D50 and 16 bits per component (PS3.3 C.10.7.1.1).
#pragma once
#include <array>
#include <cstdint>

#include "core/colour.h"

namespace simplexseg {

/// L* (0 to 100), a* and b* (-128 to 127), each mapped linearly to 0 ... 65535.
using DicomLab = std::array<std::uint16_t, 3>;

/// Converts to sRGB. Colours outside the sRGB gamut are clamped in each channel.
Colour colour_of_lab(const DicomLab& lab);
/// Converts from sRGB. colour_of_lab() of the result is exactly `colour`.
DicomLab lab_of_colour(const Colour& colour);

}  // namespace simplexseg
