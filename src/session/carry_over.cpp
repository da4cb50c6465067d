// SPDX-License-Identifier: Apache-2.0
#include "session/carry_over.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <span>
#include <utility>

#include "core/error.h"
#include "core/quantile.h"
#include "image/label_surface.h"
#include "image/rasterise.h"
#include "image/volume.h"
#include "session/follow_up.h"
#include "session/lasso.h"
#include "session/mesh_lifecycle.h"

namespace simplexseg {
namespace {

constexpr double kMostDeviations = 3;  ///< largest difference of two values that agree, deviations of the object
constexpr double kLeastEdge = 0.3;     ///< smallest contrast of an edge that agrees, share of the earlier contrast
constexpr double kSeedShare = 0.6;     ///< radius of the seed, share of that of the inscribed ball
constexpr double kLeastInside = 0.5;   ///< smallest share of a carried surface that must lie in the new image

/// Median of the values of an object and their deviation, estimated from the median absolute deviation.
struct Appearance {
  double median = 0, deviation = 1;
};

/// Values of the finite voxels inside a surface.
std::vector<double> values_inside(const SimplexMesh& mesh, const Volume& volume) {
  const Mask mask = rasterise(mesh, volume.geometry());
  std::vector<double> values;
  visit_voxel_type(volume.type(), [&]<class T>(std::type_identity<T>) {
    const std::span<const T> voxels = volume.voxels<T>();
    for (std::size_t v = 0; v < voxels.size(); ++v)
      if (const auto value = static_cast<double>(voxels[v]); mask.voxels[v] && std::isfinite(value))
        values.push_back(value);
  });
  return values;
}

std::optional<Appearance> appearance_of(const SimplexMesh& mesh, const Volume& volume) {
  std::vector<double> values = values_inside(mesh, volume);
  if (values.empty()) return std::nullopt;
  Appearance appearance;
  appearance.median = quantile(values, 0.5);
  double largest = std::abs(appearance.median);
  for (double& value : values) value = std::abs(value - appearance.median), largest = std::max(largest, value);
  appearance.deviation = std::max(kDeviationsOfMedian * quantile(values, 0.5), 1e-3 * largest);
  if (!(appearance.deviation > 0)) appearance.deviation = 1;
  return appearance;
}

/// Images of both studies with the appearance of one object in them.
struct Comparison {
  const Volume &earlier, &next;
  Appearance before, after;
  double error_mm;

  /// Deviations from the median of the object; nullopt outside the image.
  static std::optional<double> score(const Volume& volume, const Appearance& appearance, const Eigen::Vector3d& at_mm) {
    if (!volume.geometry().contains(at_mm)) return std::nullopt;
    const double value = volume.sample(at_mm);
    if (!std::isfinite(value)) return std::nullopt;
    return (value - appearance.median) / appearance.deviation;
  }

  /// Whether the new image has, within the error, a value as typical of the object as the earlier one.
  bool agrees(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& to_mm) const {
    const std::optional<double> wanted = score(earlier, before, from_mm);
    if (!wanted) return true;
    const auto is_beyond = [side = *wanted < 0 ? -1 : 1](double value) { return side * value > kMostDeviations; };
    for (int n = 0; n < 27; ++n) {
      const Eigen::Vector3d offset(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
      const std::optional<double> found = score(next, after, to_mm + error_mm * offset);
      if (!found) continue;
      // Beyond the values of the object, only the side matters: contrasts differ between images.
      if (std::abs(*found - *wanted) <= kMostDeviations || (is_beyond(*wanted) && is_beyond(*found))) return true;
    }
    return false;
  }

  /// Whether the new image has, within the error along the normal, an edge in the direction of the earlier one.
  bool edge_agrees(const Eigen::Vector3d& from_mm, const Eigen::Vector3d& outward_from, const Eigen::Vector3d& to_mm,
                   const Eigen::Vector3d& outward_to) const {
    const double step_mm = std::max(earlier.geometry().spacing_mm.minCoeff(), next.geometry().spacing_mm.minCoeff());
    const auto contrast = [&](const Volume& volume, const Appearance& appearance, const Eigen::Vector3d& at,
                              const Eigen::Vector3d& outward) -> std::optional<double> {
      const std::optional<double> in = score(volume, appearance, at - step_mm * outward);
      const std::optional<double> out = score(volume, appearance, at + step_mm * outward);
      if (!in || !out) return std::nullopt;
      return *out - *in;
    };
    const std::optional<double> wanted = contrast(earlier, before, from_mm, outward_from);
    if (!wanted || std::abs(*wanted) < 1) return true;  // there was no edge to compare
    for (double shift_mm = -error_mm; shift_mm <= error_mm + 1e-9; shift_mm += std::min(step_mm / 2, error_mm)) {
      const std::optional<double> found = contrast(next, after, to_mm + shift_mm * outward_to, outward_to);
      if (found && *found * (*wanted > 0 ? 1 : -1) >= kLeastEdge * std::abs(*wanted)) return true;
    }
    return false;
  }
};

/// Image of a direction at a point, by differences; 0 for 0.
Eigen::Vector3d mapped_direction(const Transform& transform, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& one) {
  constexpr double kStepMm = 1;
  if (!(one.norm() > 0)) return Eigen::Vector3d::Zero();
  const Eigen::Vector3d unit = one.normalized();
  const Eigen::Vector3d mapped = transform(at_mm + kStepMm * unit) - transform(at_mm - kStepMm * unit);
  return mapped.norm() > 1e-9 ? Eigen::Vector3d(mapped.normalized()) : unit;
}

/// Normal of the surface with the normal `normal` after the map: cross product of two mapped tangents.
Eigen::Vector3d mapped_normal(const Transform& transform, const Eigen::Vector3d& at_mm, const Eigen::Vector3d& normal) {
  if (!(normal.norm() > 0)) return Eigen::Vector3d::Zero();
  Eigen::Vector3d n = normal.normalized();
  const Eigen::Vector3d a = n.unitOrthogonal(), b = n.cross(a);
  const Eigen::Vector3d across = mapped_direction(transform, at_mm, a).cross(mapped_direction(transform, at_mm, b));
  if (!(across.norm() > 1e-9)) return n;
  const Eigen::Vector3d unit = across.normalized();
  return unit.dot(mapped_direction(transform, at_mm, n)) < 0 ? Eigen::Vector3d(-unit) : unit;
}

/// Moves the vertices of a lasso into the plane through their mean across its normal.
void flatten(std::vector<Eigen::Vector3d>& contour, const Eigen::Vector3d& normal) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : contour) mean += p / static_cast<double>(contour.size());
  for (Eigen::Vector3d& p : contour) p -= normal * normal.dot(p - mean);
}

std::string title_of(const UserPoint& point) {
  if (point.is_paint()) return point.kind == MarkKind::Inside ? "paint" : "eraser";
  const std::string kind = point.kind == MarkKind::Inside    ? "inside "
                           : point.kind == MarkKind::Outside ? "outside "
                                                             : "boundary ";
  return kind + (point.is_lasso() ? "lasso" : point.is_stroke() ? "stroke" : "mark");
}

/// Share of the vertices of a surface in an image.
double share_inside(const SimplexMesh& mesh, const VolumeGeometry& geometry) {
  const auto inside = std::ranges::count_if(
      mesh.positions, [&](const Eigen::Vector3f& p) { return geometry.contains(p.cast<double>()); });
  return static_cast<double>(inside) / static_cast<double>(mesh.positions.size());
}

/// Share of the values that are in a range.
double share_in(const IntensityRange& range, const std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto in = std::ranges::count_if(values, [&](double v) { return v >= range.low && v <= range.high; });
  return static_cast<double>(in) / static_cast<double>(values.size());
}

class CarryOver {
 public:
  CarryOver(const Scene& scene, const Volume& earlier, const Volume& next, const Transform& transform,
            const CarrySettings& settings)
      : from_(scene), earlier_(earlier), next_(next), transform_(transform), settings_(settings) {}

  CarriedScene run() {
    Scene& to = carried_.scene;
    to.simulation = from_.simulation, to.forces = from_.forces, to.labels = from_.labels, to.steps = from_.steps;
    for (const MeshItem& item : from_.meshes) carry_mesh(item);
    if (to.meshes.empty())
      throw Error("cannot carry the segmentations over", "none of them lies in the new image",
                  "register the images, or choose another image");
    for (const MeshItem& item : to.meshes) {
      if (settings_.marks != CarriedMarks::None)
        carry_marks(item);
      else if (const auto count = std::ranges::count(from_.points, item.id, &UserPoint::mesh); count > 0)
        drop(item, std::to_string(count) + (count == 1 ? " mark" : " marks"), "marks are not carried over");
    }
    return std::move(carried_);
  }

 private:
  void drop(const MeshItem& item, std::string what, std::string why) {
    carried_.dropped.push_back({item.name, std::move(what), std::move(why)});
  }

  void carry_mesh(const MeshItem& item) {
    if (item.mesh.positions.empty()) return drop(item, "segmentation", "it has no surface yet");
    auto surface = std::make_shared<SimplexMesh>(item.mesh);
    for (Eigen::Vector3f& p : surface->positions) p = transform_(p.cast<double>()).cast<float>();
    if (share_inside(*surface, next_.geometry()) < kLeastInside)
      return drop(item, "segmentation", "more than half of it is outside the new image");
    const Mask mask = rasterise(*surface, next_.geometry());
    if (std::ranges::find(mask.voxels, 1) == mask.voxels.end())
      return drop(item, "segmentation", "it contains no voxel of the new image");
    MeshItem to;
    to.id = item.id, to.name = item.name, to.colour = item.colour, to.visible = item.visible, to.locked = item.locked;
    to.opacity = item.opacity, to.label = item.label, to.code = item.code, to.parameters = item.parameters;
    to.final_vertices = item.final_vertices;
    const InscribedBall ball = largest_inscribed_ball(mask);
    const double voxel = voxel_mm(next_);
    to.seed = {ball.centre_mm, std::max(kSeedShare * ball.radius_mm, std::min(ball.radius_mm, voxel / 2))};
    carry_range(item, *surface, to);
    if (item.model) drop(item, "model", "the carried surface replaces it");
    if (!item.images.is_default()) drop(item, "images", "the layers of the earlier study are not in the next one");
    to.start = MeshStart{"",
                         std::nullopt,
                         0,
                         surface,
                         item.locked ? 0 : settings_.error_mm,
                         measures_of(item.mesh, earlier_.geometry())};
    restart(to, from_.simulation, next_);
    carried_.scene.meshes.push_back(std::move(to));
  }

  void carry_range(const MeshItem& item, const SimplexMesh& surface, MeshItem& to) {
    if (!item.intensity_range.is_limited()) return;
    if (item.locked) return drop(item, "range of intensities", "a locked segmentation does not use it");
    if (!(settings_.error_mm > 0))
      return drop(item, "range of intensities", "a segmentation that is the carried surface does not use it");
    const double before = share_in(item.intensity_range, values_inside(item.mesh, earlier_));
    const double after = share_in(item.intensity_range, values_inside(surface, next_));
    if (after < before / 2) return drop(item, "range of intensities", "the object has other values in the new image");
    to.intensity_range = item.intensity_range;
  }

  void carry_marks(const MeshItem& item) {
    const std::optional<Appearance> before = appearance_of(from_.find_mesh(item.id)->mesh, earlier_);
    const std::optional<Appearance> after = appearance_of(*item.start->mesh, next_);
    std::optional<Comparison> comparison;
    if (before && after && settings_.marks == CarriedMarks::Agreeing && !item.locked)
      comparison.emplace(Comparison{earlier_, next_, *before, *after, std::max(settings_.error_mm, voxel_mm(next_))});
    bool follows = true;  // whether the mark before was kept, to which the next one can be linked
    std::map<std::string, int> numbers;
    for (const UserPoint& point : from_.points) {
      if (point.mesh != item.id) continue;
      const std::string title = title_of(point) + " " + std::to_string(++numbers[title_of(point)]);
      UserPoint to = mapped(point);
      if (const std::string why = reason_to_drop(point, to, comparison); !why.empty()) {
        drop(item, title, why);
        follows = false;
        continue;
      }
      to.continues = point.continues && follows;
      follows = true;
      carried_.scene.points.push_back(std::move(to));
      ++carried_.kept_marks;
    }
  }

  UserPoint mapped(const UserPoint& point) const {
    UserPoint to = point;
    to.strokes = nullptr;
    std::vector<Eigen::Vector3d> path = point.vertices_mm();
    for (Eigen::Vector3d& p : path) p = transform_(p);
    to.outward = mapped_normal(transform_, point.position_mm, point.outward);
    if (point.is_lasso()) {
      to.lasso_normal = mapped_normal(transform_, point.position_mm, point.lasso_normal);
      flatten(path, to.lasso_normal);
    }
    to.position_mm = path.front();
    for (std::size_t v = 1; v < path.size(); ++v) to.path_mm[v - 1] = path[v] - path.front();
    return to;
  }

  std::string reason_to_drop(const UserPoint& from, UserPoint& to, const std::optional<Comparison>& comparison) const {
    if (from.is_paint()) return "the carried surface contains it, and its voxels belong to the earlier image";
    if (from.is_lasso()) {
      try {
        update_lasso(to, next_);
      } catch (const Error&) {
        return "it encloses no part of the new image";
      }
      return "";
    }
    if (!next_.geometry().contains(to.position_mm)) return "it is outside the new image";
    if (!comparison) return "";
    if (from.kind == MarkKind::Boundary) {
      const bool agrees =
          !(from.outward.norm() > 0) ||
          comparison->edge_agrees(from.position_mm, from.outward.normalized(), to.position_mm, to.outward);
      return agrees ? "" : "the new image has no such edge there";
    }
    const std::vector<Eigen::Vector3d> before = from.vertices_mm(), after = to.vertices_mm();
    std::size_t agreeing = 0;
    for (std::size_t v = 0; v < before.size(); ++v) agreeing += comparison->agrees(before[v], after[v]) ? 1 : 0;
    return 2 * agreeing >= before.size() ? "" : "the images differ there";
  }

  const Scene& from_;
  const Volume &earlier_, &next_;
  const Transform& transform_;
  const CarrySettings& settings_;
  CarriedScene carried_;
};

}  // namespace

CarriedScene carry_over(const Scene& scene, const Volume& earlier, const Volume& next, const Transform& transform,
                        const CarrySettings& settings) {
  if (earlier.empty() || next.empty())
    throw Error("cannot carry the segmentations over", "an image is missing", "open the images of both studies");
  if (scene.meshes.empty())
    throw Error("cannot carry the segmentations over", "the scene has none", "segment the earlier study first");
  if (!(settings.error_mm >= 0 && settings.error_mm <= kMaxErrorMm))
    throw Error("the expected error of carried surfaces", "it is out of range", "use a deviation of 0 to 100 mm");
  return CarryOver(scene, earlier, next, transform, settings).run();
}

}  // namespace simplexseg
