// SPDX-License-Identifier: Apache-2.0
#include "io/scene/point_text.h"

#include <algorithm>
#include <vector>

#include "core/number_text.h"
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

IntensityRange read_range(const JsonInput& input) {
  input.expect_keys({"low", "high"});
  IntensityRange range;
  if (input.has("low")) range.low = input["low"].number();
  if (input.has("high")) range.high = input["high"].number();
  if (!(range.low < range.high)) input.fail("its lower limit is not below the upper one", "correct it");
  return range;
}

VoxelEdit read_voxel_edit(const JsonInput& input) {
  const std::string name = input.text();
  std::vector<std::string> names;
  for (const VoxelEditInfo& info : voxel_edits()) {
    if (name == info.name) return info.edit;
    names.emplace_back(info.name);
  }
  input.fail("the edit " + unknown_name(name, names), "correct it");
}

std::shared_ptr<const PaintVoxels> read_voxels(const JsonInput& input) {
  constexpr std::size_t kMostVoxels = std::size_t{1} << 28;
  input.expect_keys({"size", "spacing_mm", "origin_mm", "direction", "runs"});
  auto voxels = std::make_shared<PaintVoxels>();
  const Eigen::Vector3d size = input["size"].vector3();
  for (int a = 0; a < 3; ++a) voxels->box.size[a] = input["size"][a].integer_between(1, 1 << 20);
  if (size.prod() > static_cast<double>(kMostVoxels))
    input["size"].fail("the box is too large", "use at most 2^28 voxels");
  voxels->box.spacing_mm = input["spacing_mm"].vector3();
  voxels->box.origin_mm = input["origin_mm"].vector3();
  if (input["direction"].size() != 3) input["direction"].fail("it has not three axes", "use the axes i, j, k");
  for (int a = 0; a < 3; ++a) voxels->box.direction.col(a) = input["direction"][a].vector3();
  voxels->box.validate(input.where());
  const std::string text = input["runs"].text();
  std::vector<std::uint32_t> lengths;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::optional<std::int64_t> length = parse_integer(std::string_view(text).substr(at, end - at));
    if (!length || *length < 0 || *length > static_cast<std::int64_t>(kMostVoxels))
      input["runs"].fail("it is not a list of lengths", "use whole numbers, separated by one blank");
    lengths.push_back(static_cast<std::uint32_t>(*length));
    at = end + 1;
  }
  voxels->voxels = voxels_of_runs(lengths, voxels->box.voxel_count());
  return voxels;
}

std::shared_ptr<const PaintVoxels> read_paint(const JsonInput& input, PaintBrush& brush, VoxelEdit& edit) {
  input.expect_keys({"contour", "normal", "thickness_mm", "edit", "voxels"});
  if (input.has("edit")) edit = read_voxel_edit(input["edit"]);
  brush = PaintBrush::ball();
  if (input.has("voxels")) {
    brush = {PaintBrush::Shape::Voxels};
    return read_voxels(input["voxels"]);
  }
  const bool contour = input.has("contour") && input["contour"].boolean();
  if (!contour && !input.has("normal") && !input.has("thickness_mm")) return nullptr;
  const Eigen::Vector3d normal = input["normal"].vector3();
  const double thickness_mm = input["thickness_mm"].number();
  brush = contour ? PaintBrush::contour(normal, thickness_mm) : PaintBrush::disc(normal, thickness_mm);
  return nullptr;
}

MeasurementKind read_measurement_kind(const JsonInput& input) {
  const std::string name = input.text();
  const std::optional<MeasurementKind> kind = find_measurement_kind(name);
  if (!kind) input.fail("the kind of measurement " + unknown_name(name, {"ruler", "angle", "ellipse"}), "correct it");
  return *kind;
}

}  // namespace simplexseg
