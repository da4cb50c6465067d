// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/platform/run_worker.h"

namespace simplexseg {

/// Returns all requests of the program simplexseg-reader: those of dicom_requests.h and minc_requests.h.
RequestTable reader_requests();

}  // namespace simplexseg
