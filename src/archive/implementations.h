// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "archive/archive.h"

namespace simplexseg {

/// By libcurl.
std::unique_ptr<Archive> open_dicom_web(const ArchiveServer& server);
/// By DCMTK.
std::unique_ptr<Archive> open_dimse(const ArchiveServer& server);

}  // namespace simplexseg
