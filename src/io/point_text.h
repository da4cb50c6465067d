// SPDX-License-Identifier: Apache-2.0
// How scene files and logs write what belongs to a point.
#pragma once
#include <optional>
#include <string>

#include "session/scene.h"

namespace simplexseg {

class JsonInput;

/// "inside", "outside" or "boundary".
const char* name_of(MarkKind kind);
/// None when there is none of that name.
std::optional<MarkKind> find_point_kind(const std::string& name);
MarkKind read_point_kind(const JsonInput& input);
/// A radius in mm, above 0.
double read_radius(const JsonInput& input);

}  // namespace simplexseg
