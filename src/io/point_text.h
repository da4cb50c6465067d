// SPDX-License-Identifier: Apache-2.0
// How scene files and logs write what belongs to a point.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// "inside", "outside" or "boundary".
const char* name_of(MarkKind kind);
MarkKind read_point_kind(const JsonInput& input);
/// A radius in mm, above 0.
double read_radius(const JsonInput& input);

}  // namespace simplexseg
