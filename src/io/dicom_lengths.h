// SPDX-License-Identifier: Apache-2.0
// What of a DICOM file is held against its size before GDCM takes memory for it.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "io/dicom_slice.h"

namespace simplexseg {

/// Whether a file begins as those of DICOM do, with or without a preamble. GDCM must not be let at others: it searches
/// them for elements and takes the memory that those claim.
bool begins_as_dicom(const std::filesystem::path& path);

/// Walks the elements of a file, down into its sequences and up to its pixels, without keeping any. Says what is wrong:
/// it begins as no DICOM, an element claims more than the file holds, or the coding breaks off; empty when GDCM can be
/// let at it.
std::string damage_of_header(const std::filesystem::path& path);

/// Holds the fragments of compressed pixels, the first of which begins at pixels.start, against what the header claims:
/// that they end within the file, that there is one for each frame, that the size their own headers name is that of the
/// image, and that they are not too small for what they unpack to. Says what is wrong; empty when nothing is.
std::string damage_of_fragments(const std::filesystem::path& path, const DicomPixels& pixels);

}  // namespace simplexseg
