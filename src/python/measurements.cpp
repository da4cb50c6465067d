// SPDX-License-Identifier: Apache-2.0
#include "image/measurement.h"

#include <pybind11/stl.h>

#include "core/error.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/items.h"

namespace simplexseg::python {
namespace {

/// Returns a copy of a measurement of the scene.
Measurement measurement_of(const SceneMeasurement& item) {
  return item.session->use([&](const Session& session) {
    const Measurement* const found = session.scene_without_poses().find_measurement(item.id);
    if (!found)
      throw Error("measurement " + std::to_string(item.id), "it is no longer in the scene", "use another measurement");
    return *found;
  });
}

std::vector<Eigen::Vector3d> positions_of(const std::vector<py::object>& points) {
  std::vector<Eigen::Vector3d> positions;
  positions.reserve(points.size());
  for (const py::object& point : points) positions.push_back(vector_of(point, "points"));
  return positions;
}

py::list tuples_of(std::span<const Eigen::Vector3d> positions) {
  py::list list;
  for (const Eigen::Vector3d& position : positions) list.append(tuple_of(position));
  return list;
}

py::dict values_dict(const SceneMeasurement& item) {
  const Measurement measurement = measurement_of(item);
  const Volume volume = item.session->image().volume;
  const MeasurementValues values = [&] {
    const WithoutGil released;
    return values_of(measurement, volume);
  }();
  py::dict dict;
  if (values.length_mm) dict["length_mm"] = *values.length_mm;
  if (values.angle_degrees) dict["angle_degrees"] = *values.angle_degrees;
  if (values.area_mm2) dict["area_mm2"] = *values.area_mm2;
  if (const auto& found = values.intensities) {
    dict["mean"] = found->mean, dict["deviation"] = found->deviation;
    dict["minimum"] = found->minimum, dict["maximum"] = found->maximum;
    dict["voxels"] = found->voxels;
  }
  return dict;
}

}  // namespace

std::vector<SceneMeasurement> measurements_of(const std::shared_ptr<SessionOwner>& session) {
  return session->use([&](const Session& s) {
    std::vector<SceneMeasurement> measurements;
    for (const Measurement& item : s.scene_without_poses().measurements) measurements.push_back({{session, item.id}});
    return measurements;
  });
}

SceneMeasurement add_measurement(const std::shared_ptr<SessionOwner>& session, const std::string& kind,
                                 const std::vector<py::object>& points, const std::string& name) {
  const std::optional<MeasurementKind> found = find_measurement_kind(kind);
  if (!found) throw Error("kind '" + kind + "'", "no kind has this name", "use ruler, angle or ellipse");
  return {{session, apply(*session, AddMeasurement{*found, positions_of(points), name})}};
}

void bind_measurements(py::module_& module) {
  py::class_<SceneMeasurement>(
      module, "SceneMeasurement",
      "A ruler, an angle or an ellipse in the scene of a session. Raises Error like SceneMesh.")
      .def("__eq__",
           [](const SceneMeasurement& one, const py::object& other) {
             return py::isinstance<SceneMeasurement>(other) && one == other.cast<const SceneMeasurement&>();
           })
      .def("__hash__", [](const SceneMeasurement& one) { return std::hash<const void*>()(one.session.get()) ^ one.id; })
      .def_property_readonly(
          "id", [](const SceneMeasurement& one) { return one.id; }, "Unique in a session, also in its logs.")
      .def_property_readonly(
          "kind", [](const SceneMeasurement& one) { return name_of(measurement_of(one).kind); },
          "Kind: ruler, angle or ellipse.")
      .def_property(
          "name", [](const SceneMeasurement& one) { return measurement_of(one).name; },
          [](const SceneMeasurement& one, const py::str& name) {
            apply(*one.session, RenameMeasurement{one.id, name.cast<std::string>()});
          },
          "Name in tables.")
      .def_property_readonly(
          "points", [](const SceneMeasurement& one) { return tuples_of(measurement_of(one).points_mm); },
          "Points, mm, LPS: two ends of a ruler; end, vertex and end of an angle; centre and one end of each semi-axis "
          "of "
          "an\n"
          "ellipse.")
      .def_property_readonly(
          "values", &values_dict,
          "Values as a dict: length_mm; angle_degrees; or area_mm2 and, of the voxels in an ellipse, "
          "mean,\n"
          "deviation (population), minimum, maximum and voxels (their number).")
      .def(
          "move",
          [](const SceneMeasurement& one, const std::vector<py::object>& points) {
            apply(*one.session, MoveMeasurement{one.id, positions_of(points)});
          },
          py::arg("points"), "Replaces the points. Raises Error for points that are not of its kind.")
      .def(
          "delete", [](const SceneMeasurement& one) { apply(*one.session, DeleteMeasurement{one.id}); },
          "Deletes the measurement.");
}

}  // namespace simplexseg::python
