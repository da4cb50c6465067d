// SPDX-License-Identifier: Apache-2.0
#include "io/scene/point_text.h"

#include <algorithm>
#include <vector>

#include "io/scene/json_input.h"
#include "io/scene/parameter_text.h"

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
  if (!kind) input.fail("the kind of point " + unknown_name(name, kKinds), "correct it");
  return *kind;
}

double read_radius(const JsonInput& input) {
  const double radius = input.number();
  if (!(radius > 0)) input.fail("the radius is not above 0", "use a radius in mm");
  if (radius > kMaxMillimetres) input.fail("the radius is above 1e+12 mm", "use a radius in mm");
  return radius;
}

std::vector<Eigen::Vector3d> read_path(const JsonInput& input) {
  std::vector<Eigen::Vector3d> path;
  path.reserve(input.size());
  for (int p = 0; p < input.size(); ++p) path.push_back(input[p].vector3());
  return path;
}

PaintBrush read_brush(const JsonInput& input) {
  input.expect_keys({"normal", "thickness_mm"});
  if (!input.has("normal") && !input.has("thickness_mm")) return PaintBrush::ball();
  return PaintBrush::disc(input["normal"].vector3(), input["thickness_mm"].number());
}

}  // namespace simplexseg
