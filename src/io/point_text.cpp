// SPDX-License-Identifier: Apache-2.0
#include "io/point_text.h"

#include <algorithm>
#include <vector>

#include "io/json_input.h"
#include "io/parameter_text.h"

namespace simplexseg {

static const std::vector<std::string> kKinds = {"inside", "outside", "boundary"};  // in the order of MarkKind

const char* name_of(MarkKind kind) { return kKinds.at(static_cast<std::size_t>(kind)).c_str(); }

std::optional<MarkKind> find_point_kind(const std::string& name) {
  const auto found = std::find(kKinds.begin(), kKinds.end(), name);
  if (found == kKinds.end()) return std::nullopt;
  return static_cast<MarkKind>(found - kKinds.begin());
}

MarkKind read_point_kind(const JsonInput& input) {
  const std::string name = input.text();
  const std::optional<MarkKind> kind = find_point_kind(name);
  if (!kind) input.refuse("the kind of point " + unknown_name(name, kKinds), "correct it");
  return *kind;
}

double read_radius(const JsonInput& input) {
  const double radius = input.number();
  if (!(radius > 0)) input.refuse("a radius must be above 0", "give one in mm");
  if (radius > kMostMillimetres) input.refuse("the radius is beyond 1e+12 mm", "give one in mm");
  return radius;
}

}  // namespace simplexseg
