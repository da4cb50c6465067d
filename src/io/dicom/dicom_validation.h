// SPDX-License-Identifier: Apache-2.0
// Checks of a DICOM file against its size, before GDCM allocates memory for it.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Returns true when the file starts with the DICOM preamble or with a plausible first element. A file without preamble
/// is also read in a worker process: GDCM guesses its encoding and allocates the memory that the guessed lengths
/// require. GDCM must not read files for which this function returns false.
bool has_dicom_header(const std::filesystem::path& path);

/// Parses all elements and sequences of a file without storing them. Returns a description of the damage: it does not
/// start like DICOM, an element is longer than the file, the encoding is invalid, or a file without transfer syntax
/// fails in a worker process. Returns an empty text when GDCM can read the file safely, provided that
/// has_dicom_header() is true.
std::string damage_of_header(const std::filesystem::path& path);

/// Checks the fragments of compressed pixels, which start at pixels.start, against the header: they must end within the
/// file, there must be one for each frame, the image size in their own headers must match, and they must not be too
/// small for the decompressed size. Returns a description of the damage; empty when there is none.
std::string damage_of_fragments(const std::filesystem::path& path, const DicomPixels& pixels);

}  // namespace simplexseg
