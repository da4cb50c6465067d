// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/platform/run_worker.h"

namespace simplexseg::in_register {

/// Returns all requests of the program simplexseg-register: those of registration_requests.h.
RequestTable register_requests();

}  // namespace simplexseg::in_register
