// SPDX-License-Identifier: Apache-2.0
// Checks of the lengths in a DICOM file against its size, before GDCM allocates memory for them.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "io/source/dicom_slice.h"

namespace simplexseg {

/// Returns true when a plausible first element follows the DICOM preamble or, without preamble, starts the file. A file
/// without preamble must also be readable by GDCM in a worker process, because GDCM guesses its encoding and allocates
/// the memory that the guessed lengths require. Files for which this function returns false must not be passed to GDCM.
bool has_dicom_header(const std::filesystem::path& path);

/// Parses all elements and sequences of a file without storing them. Returns a description of the damage: the file does
/// not start like DICOM, an element longer than 1 MiB exceeds the end of the file, the encoding is invalid, or a worker
/// process cannot read a file with preamble but without transfer syntax. Returns an empty text when GDCM can read the
/// file safely, provided that has_dicom_header() is true.
std::string damage_of_header(const std::filesystem::path& path);

/// Checks the fragments of compressed pixels, which start at pixels.start, against the header: they must end within the
/// file, there must be at least one for each frame, the image size in their own headers must match, and fragments of
/// more than 64 MB of decompressed pixels must not be too small for that size. Returns a description of the damage;
/// empty when there is none.
std::string damage_of_fragments(const std::filesystem::path& path, const DicomPixels& pixels);

}  // namespace simplexseg
