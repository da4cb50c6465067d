// SPDX-License-Identifier: Apache-2.0
#include "session/scene_checks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "core/error.h"
#include "field/brush_radius.h"
#include "forces/force_list.h"
#include "image/volume.h"
#include "model/organ_model.h"
#include "session/filtered_volumes.h"
#include "session/lasso.h"

namespace simplexseg {
namespace {

std::string text_of(const Eigen::Vector3d& p) {
  std::ostringstream text;
  text << "(" << p[0] << ", " << p[1] << ", " << p[2] << ")";
  return text.str();
}

void check_values(const Scene& scene) {
  for (std::size_t k = 0; k < simulation_table().size(); ++k)
    check_value(simulation_table()[k], value_of(scene.simulation, static_cast<int>(k)), "simulation");
}

void check_mesh(const MeshItem& item, const Scene& scene, const Volume& volume) {
  for (const ForceInfo& force : force_list())
    for (std::size_t k = 0; k < force.parameters.size(); ++k)
      check_value(force.parameters[k], item.parameters.values[static_cast<int>(force.id)][k],
                  "segmentation '" + item.name + "', " + force.name);
  check_seed(item.seed, item.name, volume);
  check_code(item.code, item.name);
  check_range(item, item.intensity_range);
  check_model(item, item.model.get());
  check_images(scene, item.images, item.name);
  check_start_modes(item);
  if (item.model_profiles) check_model_profiles(item);
  if (!item.mesh.positions.empty()) validate(item.mesh);
}

}  // namespace

void check_value(const ParameterInfo& info, float value, const std::string& owner) {
  if (value >= info.minimum && value <= info.maximum) return;
  std::ostringstream range;
  range << "give a value from " << info.minimum << " to " << info.maximum;
  std::ostringstream why;
  why << value << " is out of range";
  throw Error(owner + " " + info.name, why.str(), range.str());
}

void refuse_locked(const MeshItem& item) {
  if (item.locked) throw Error("segmentation '" + item.name + "'", "it is locked", "unlock it first");
}

void check_seed(const Seed& seed, const std::string& name, const Volume& volume) {
  if (!seed.centre_mm.allFinite() || !std::isfinite(seed.radius_mm) || !(seed.radius_mm > 0))
    throw Error("segmentation '" + name + "'",
                "the centre or radius of its sphere is not a finite number, or the radius is not above 0",
                "correct the sphere");
  if (!volume.empty() && !volume.geometry().contains(seed.centre_mm))
    throw Error("segmentation '" + name + "'",
                "the centre of its sphere, " + text_of(seed.centre_mm) + " mm, lies outside the image",
                "move it inside; the centre of the image is " + text_of(volume.geometry().centre_mm()));
}

void check_position(const Eigen::Vector3d& position_mm) {
  if (!position_mm.allFinite() || position_mm.cwiseAbs().maxCoeff() > 1e9)
    throw Error("point", "its position is not a finite number within 1e9 mm", "correct the position");
}

void check_radius(double radius_mm) {
  if (!(radius_mm > 0 && radius_mm <= 1000))
    throw Error("point", "its radius is not above 0 and at most 1000 mm", "correct the radius");
}

void check_mark(MarkKind kind, const Eigen::Vector3d& position_mm, const Volume& volume) {
  if (kind == MarkKind::Boundary) return;
  if (volume.empty() || !volume.geometry().contains(position_mm))
    throw Error(kind == MarkKind::Inside ? "inside point" : "outside point",
                volume.empty() ? "there is no volume" : text_of(position_mm) + " mm lies outside the image",
                "place it in the image");
}

void check_path(MarkKind kind, const std::vector<Eigen::Vector3d>& path_mm) {
  constexpr std::size_t kMostVertices = 10'000;
  if (path_mm.empty()) return;
  if (kind == MarkKind::Boundary)
    throw Error("boundary point", "it has a path, but only inside and outside points can be strokes",
                "make it an inside or an outside stroke");
  if (path_mm.size() > kMostVertices)
    throw Error("stroke", "its path has " + std::to_string(path_mm.size()) + " vertices, the largest number is 10000",
                "divide it into several strokes");
  for (const Eigen::Vector3d& offset : path_mm) check_position(offset);
}

void check_stroke(const std::vector<Eigen::Vector3d>& path_mm, double radius_mm) {
  constexpr double kMostRadii = 2000;
  double length_mm = 0;
  Eigen::Vector3d last(0, 0, 0);
  for (const Eigen::Vector3d& offset : path_mm) length_mm += (offset - last).norm(), last = offset;
  if (!(length_mm <= kMostRadii * radius_mm))
    throw Error("stroke", "it is longer than 2000 of its radii", "draw shorter strokes, or enlarge the radius");
}

void check_paint(const UserPoint& point) {
  using Shape = PaintBrush::Shape;
  constexpr double kMostMm = 100;
  const PaintBrush& brush = point.brush;
  if (point.kind == MarkKind::Boundary)
    throw Error("paint", "it belongs to a boundary point", "make it an inside or an outside stroke");
  if ((brush.shape == Shape::Voxels) != (point.voxels != nullptr))
    throw Error("paint", "only a set of voxels has voxels", "correct the brush");
  if (brush.has_radius()) {
    check_radius(point.radius_mm);
    if (point.radius_mm > kMostMm) throw Error("paint", "its radius is above 100 mm", "use a smaller brush");
  }
  const bool in_slice = brush.thickness_mm <= 1000 && std::abs(brush.normal.norm() - 1) < 1e-6;
  if (brush.shape == Shape::Disc && !(in_slice && brush.thickness_mm > 0))
    throw Error("paint", "its brush is a disc without a unit normal or without a thickness from 0 to 1000 mm",
                "correct the brush");
  if (brush.shape != Shape::Contour) return;
  if (!(in_slice && brush.thickness_mm >= 0))
    throw Error("paint", "its contour has no unit normal, or a thickness that is not from 0 to 1000 mm",
                "correct the brush");
  if (point.path_mm.size() < 2) throw Error("paint", "its contour has fewer than three vertices", "draw a larger one");
}

void check_range(const MeshItem& item, const IntensityRange& range) {
  if (!(range.low < range.high))
    throw Error("the range of intensities of '" + item.name + "'", "its lower limit is not below the upper one",
                "correct it");
  if (item.is_given() && range.is_limited())
    throw Error("the range of intensities of '" + item.name + "'",
                "the segmentation starts from labels or a mesh, which the image does not change",
                "start it from a seed to limit its intensities");
}

void check_model(const MeshItem& item, const MeshModel* model) {
  if (!model) return;
  if (!model->organ) throw Error("the model of '" + item.name + "'", "it was not read", "read its file first");
  if (item.start)
    throw Error("the model of '" + item.name + "'",
                "the segmentation starts from labels, a mesh or a network, which replaces a model",
                "start it from a seed to use a model");
}

void check_start_modes(const MeshItem& item) {
  const std::string owner = "the start shape of '" + item.name + "'";
  if (item.start_modes.empty()) return;
  if (!item.model || !item.model->organ) throw Error(owner, "it has no model", "choose a model first");
  const int modes = item.model->organ->shape.mode_count();
  if (std::ssize(item.start_modes) > modes)
    throw Error(
        owner,
        "it has " + std::to_string(item.start_modes.size()) + " modes, but its model only " + std::to_string(modes),
        "give a value for each of the first modes");
  for (const float value : item.start_modes)
    if (!(std::abs(value) <= kMostModeDeviations))
      throw Error(owner, "a mode is not a number from -5 to 5", "give deviations from -5 to 5");
}

void check_model_profiles(const MeshItem& item) {
  if (!item.model || item.start_modes.empty())
    throw Error("the profiles of '" + item.name + "'", "it does not start from the shape of a model",
                "choose a model and a start shape first");
}

void check_code(const SegmentCode& code, const std::string& name) {
  if (const std::string fault = fault_of(code); !fault.empty())
    throw Error("the code of segmentation '" + name + "'", fault, "correct it, or choose a name of a label preset");
}

void check_labels(const std::map<std::string, int>& by_name) {
  std::set<int> labels;
  for (const auto& [name, label] : by_name) {
    if (name.empty() || label < 1 || label > 65535)
      throw Error("label " + std::to_string(label) + " of the name '" + name + "'",
                  name.empty() ? "the name is empty" : "labels have 16 bits and 0 is background",
                  name.empty() ? "give every label a name" : "choose 1 to 65535");
    if (!labels.insert(label).second)
      throw Error("label " + std::to_string(label) + " of the name '" + name + "'", "another name has it",
                  "give every name another label");
  }
}

void check_measurement(MeasurementKind kind, const std::vector<Eigen::Vector3d>& points_mm) {
  if (const std::optional<std::string> defect = defect_of(kind, points_mm))
    throw Error(name_of(kind), *defect, "correct its points");
}

ItemId check_scene(Scene& scene, const Volume& volume) {
  check_values(scene);
  check_labels(scene.labels.by_name);
  check_volume_filters(scene.volume_preprocessing);
  std::set<ItemId> ids;
  ItemId next = 1;
  for (const MeshItem& item : scene.meshes) next = std::max(next, item.id + 1);
  for (const UserPoint& point : scene.points) next = std::max(next, point.id + 1);
  for (const Measurement& measurement : scene.measurements) next = std::max(next, measurement.id + 1);
  for (const LayerItem& layer : scene.layers) next = std::max(next, layer.id + 1);
  for (MeshItem& item : scene.meshes) {
    if (item.id == 0) item.id = next++;
    if (!ids.insert(item.id).second)
      throw Error("segmentation '" + item.name + "'", "its id is used twice", "give each segmentation a different id");
    check_mesh(item, scene, volume);
  }
  for (UserPoint& point : scene.points) {
    if (point.id == 0) point.id = next++;
    if (point.is_lasso()) {
      try {
        update_lasso(point, volume);
      } catch (const Error& error) {
        throw Error("points[" + std::to_string(&point - scene.points.data()) + "]: " + error.what());
      }
    } else {
      check_position(point.position_mm);
      check_mark(point.kind, point.position_mm, volume);
      check_path(point.kind, point.path_mm);
    }
    if (point.is_paint())
      check_paint(point);
    else if (point.is_stroke() && !point.is_lasso())
      check_stroke(point.path_mm, point.radius_mm > 0 ? point.radius_mm : far_brush_radius_mm(volume.geometry()));
    if (!(point.radius_mm >= 0) || !std::isfinite(point.radius_mm) || !point.outward.allFinite())
      throw Error("point " + std::to_string(point.id), "its radius or its direction is not a finite number",
                  "correct them, or leave them out");
    if ((point.edit != VoxelEdit::None) != (point.voxels != nullptr))
      throw Error("paint", "a set of voxels and the edit that determined it must be given together",
                  "correct the scene");
    if (!scene.find_mesh(point.mesh))
      throw Error("point", "it refers to a segmentation that is not in the scene", "choose one of the scene");
  }
  for (Measurement& measurement : scene.measurements) {
    if (measurement.id == 0) measurement.id = next++;
    check_measurement(measurement.kind, measurement.points_mm);
  }
  for (LayerItem& layer : scene.layers) {
    if (layer.id == 0) layer.id = next++;
    check_layer(layer);
  }
  return next;
}

}  // namespace simplexseg
