// SPDX-License-Identifier: Apache-2.0
// What of a DICOM file is held against its size before GDCM takes memory for it.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "io/dicom_slice.h"

namespace simplexseg {

/// Whether a file begins as those of DICOM do. One without a preamble is tried in a child process besides: GDCM guesses
/// how it is coded, and takes the memory that what it finds then claims. It must not be let at others.
bool begins_as_dicom(const std::filesystem::path& path);

/// Walks the elements of a file, down into its sequences and up to its pixels, without keeping any. Says what is wrong:
/// it begins as no DICOM, an element claims more than the file holds, the coding breaks off, or what does not say how
/// it is coded fails in a child process; empty when GDCM can be let at it, where begins_as_dicom().
std::string damage_of_header(const std::filesystem::path& path);

/// Holds the fragments of compressed pixels, the first of which begins at pixels.start, against what the header claims:
/// that they end within the file, that there is one for each frame, that the size their own headers name is that of the
/// image, and that they are not too small for what they unpack to. Says what is wrong; empty when nothing is.
std::string damage_of_fragments(const std::filesystem::path& path, const DicomPixels& pixels);

}  // namespace simplexseg
