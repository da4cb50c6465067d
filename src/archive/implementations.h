// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>

#include "archive/archive.h"

namespace simplexseg {

constexpr std::size_t kMaxInstances = 100000;  ///< largest number of instances in a series

/// Opens an archive over DICOMweb, with libcurl.
std::unique_ptr<Archive> open_dicom_web(const ArchiveServer& server);
/// Opens an archive over DIMSE, with DCMTK.
std::unique_ptr<Archive> open_dimse(const ArchiveServer& server);

}  // namespace simplexseg
