// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <pybind11/pybind11.h>

#include "core/segment_code.h"

namespace simplexseg::python {

/// Dictionary with the keys category, type and, if there is one, modifier; each is a tuple (scheme, value, meaning).
pybind11::dict code_dict(const SegmentCode& code);
/// Codes of such a dictionary; empty for an empty one. Throws Error for other keys or values, or if the type is
/// missing.
SegmentCode code_of_python(const pybind11::object& code);

}  // namespace simplexseg::python
