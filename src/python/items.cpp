// SPDX-License-Identifier: Apache-2.0
#include "python/items.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <filesystem>
#include <optional>

#include "forces/step_view.h"
#include "io/scene/label_preset.h"
#include "io/scene/mesh_model.h"
#include "io/scene/point_text.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/codes.h"
#include "python/mesh.h"
#include "python/messages.h"
#include "python/parameters.h"

namespace simplexseg::python {
namespace {

MarkKind kind_of(const std::string& name) {
  if (const std::optional<MarkKind> kind = find_point_kind(name)) return *kind;
  throw Error("kind '" + name + "'", "no kind has this name", "use boundary, inside or outside");
}

/// Returns the result of `read(item)`, a copy of data of a mesh. `with_pose`: reads back the pose of the last step.
template <class Read>
auto read_mesh_item(const SceneMesh& mesh, Read read, bool with_pose = false) {
  return mesh.session->use([&](const Session& session) {
    const Scene& scene = with_pose ? session.scene() : session.scene_without_poses();
    const MeshItem* const item = scene.find_mesh(mesh.id);
    if (!item) throw Error("mesh " + std::to_string(mesh.id), "it is no longer in the scene", "use another mesh");
    return read(*item);
  });
}

template <class Read>
auto read_point(const ScenePoint& point, Read read) {
  return point.session->use([&](const Session& session) {
    const UserPoint* const item = session.scene_without_poses().find_point(point.id);
    if (!item) throw Error("point " + std::to_string(point.id), "it is no longer in the scene", "use another point");
    return read(*item);
  });
}

/// Returns a setter that applies an EditMesh with one member set.
template <class T>
auto edit(std::optional<T> EditMesh::*member) {
  return [member](const SceneMesh& mesh, const T& value) {
    EditMesh command{mesh.id, {}, {}, {}, {}};
    command.*member = value;
    apply(*mesh.session, command);
  };
}

template <class T>
auto member_of(T MeshItem::*member) {
  return [member](const SceneMesh& mesh) {
    return read_mesh_item(mesh, [&](const MeshItem& item) { return item.*member; });
  };
}

Surface surface_of(const SceneMesh& mesh) {
  return read_mesh_item(
      mesh, [](const MeshItem& item) { return Surface(item.mesh); }, true);
}

py::object get_parameter(const SceneMesh& mesh, const std::string& name) {
  const FoundParameter found = find_named(name);
  if (!found.force) throw Error("parameter '" + name + "'", "it is not a parameter of a mesh", "use Session.get()");
  return python_value(*found.info, read_mesh_item(mesh, [&](const MeshItem& item) {
    return item.parameters.values[static_cast<int>(found.force->id)][found.index];
  }));
}

ScenePoint add_point(const SceneMesh& mesh, const py::object& position, const std::string& kind, double radius,
                     const py::object& outward, const std::optional<std::vector<py::object>>& path, bool local) {
  AddPoint command{mesh.id, vector_of(position, "position"), kind_of(kind), radius};
  for (const py::object& vertex : path.value_or(std::vector<py::object>()))
    command.path_mm.emplace_back(vector_of(vertex, "path") - command.position_mm);
  if (!(radius >= 0))
    throw Error("radius", "it is negative or not a number", "use a radius in mm, or 0 for the default");
  command.local = local;
  if (!outward.is_none()) command.outward = vector_of(outward, "outward");
  return {{mesh.session, apply(*mesh.session, command)}};
}

/// Edit with a name, among those that use a stroke or among the others. Throws Error if there is none.
VoxelEdit voxel_edit_of(const std::string& name, bool uses_stroke) {
  std::string names;
  for (const VoxelEditInfo& info : voxel_edits()) {
    if (info.uses_stroke != uses_stroke) continue;
    if (name == info.name) return info.edit;
    names += (names.empty() ? "" : ", ") + std::string(info.name);
  }
  throw Error("the edit '" + name + "'", "it is unknown here", "use one of " + names);
}

ScenePoint edit_voxels(const SceneMesh& mesh, const std::string& name, const std::optional<double>& size,
                       const std::optional<SceneMesh>& other) {
  if (other && other->session != mesh.session)
    throw Error("other", "it is a mesh of another session", "use a mesh of this session");
  const VoxelEdit edit = voxel_edit_of(name, false);
  const double default_size = info_of(edit).size.default_value;
  return {{mesh.session,
           apply(*mesh.session, EditVoxels{mesh.id, edit, size.value_or(default_size), other ? other->id : 0})}};
}

ScenePoint add_lasso(const SceneMesh& mesh, const std::vector<py::object>& path, const py::object& normal,
                     const std::string& kind, bool local) {
  AddLasso command{mesh.id, kind_of(kind), {}, vector_of(normal, "normal").normalized(), local};
  for (const py::object& vertex : path) command.contour_mm.emplace_back(vector_of(vertex, "path"));
  return {{mesh.session, apply(*mesh.session, command)}};
}

ScenePoint paint(const SceneMesh& mesh, const std::vector<py::object>& path, double radius, bool erase,
                 const py::object& normal, double thickness, bool contour, const std::optional<std::string>& edit) {
  if (path.empty()) throw Error("path", "it has no vertex", "give at least one position");
  if (contour && normal.is_none()) throw Error("contour", "it has no normal", "give the normal of its slice");
  AddPoint command{mesh.id, vector_of(path[0], "path"), erase ? MarkKind::Outside : MarkKind::Inside, radius};
  for (std::size_t p = 1; p < path.size(); ++p)
    command.path_mm.emplace_back(vector_of(path[p], "path") - command.position_mm);
  const Eigen::Vector3d unit =
      normal.is_none() ? Eigen::Vector3d(0, 0, 0) : Eigen::Vector3d(vector_of(normal, "normal").normalized());
  command.brush = contour            ? PaintBrush::contour(unit, thickness)
                  : normal.is_none() ? PaintBrush::ball()
                                     : PaintBrush::disc(unit, thickness);
  if (edit) command.edit = voxel_edit_of(*edit, true);
  return {{mesh.session, apply(*mesh.session, command)}};
}

/// Returns the foreground probability (0..1) on the box of the field; none if there is no field.
std::optional<Image> evidence(const SceneMesh& mesh) {
  const auto field = read_mesh_item(mesh, [](const MeshItem& item) { return item.field; });
  if (!field || field->values.empty()) return std::nullopt;
  Volume volume(field->grid(mesh.session->image().volume.geometry()), VoxelType::Float32);
  const auto out = volume.voxels<float>();
  for (std::size_t v = 0; v < out.size(); ++v) {
    const auto value = static_cast<float>(field->values[v]);
    out[v] = value >= kFieldFloor ? value / kFieldScale : 0.0f;
  }
  return Image{std::move(volume)};
}

py::tuple colour_of(const SceneMesh& mesh) {
  const Colour colour = read_mesh_item(mesh, [](const MeshItem& item) { return item.colour; });
  return py::make_tuple(colour.red, colour.green, colour.blue);
}

void set_name(const SceneMesh& mesh, const py::str& name) {  // py::str excludes bytes, which may not be valid text
  edit (&EditMesh::name)(mesh, name.cast<std::string>());
}

void set_colour(const SceneMesh& mesh, const std::array<std::uint8_t, 3>& colour) {
  edit (&EditMesh::colour)(mesh, {colour[0], colour[1], colour[2]});
}

std::pair<double, double> intensity_range_of(const SceneMesh& mesh) {
  const IntensityRange range = read_mesh_item(mesh, [](const MeshItem& item) { return item.intensity_range; });
  return {range.low, range.high};
}

void set_intensity_range(const SceneMesh& mesh, const std::pair<double, double>& range) {
  apply(*mesh.session, SetIntensityRange{mesh.id, {range.first, range.second}});
}

py::object model_of(const SceneMesh& mesh) {
  const auto model = read_mesh_item(mesh, [](const MeshItem& item) { return item.model; });
  return model ? py::object(python_text(model->path)) : py::none();
}

void set_model(const SceneMesh& mesh, const std::optional<std::filesystem::path>& path) {
  SetModel command{mesh.id, nullptr};
  if (path) command.model = load_mesh_model(std::filesystem::absolute(*path).string(), {});
  apply(*mesh.session, command);
}

py::dict code_of_mesh(const SceneMesh& mesh) {
  return code_dict(read_mesh_item(mesh, [](const MeshItem& item) { return code_of(item); }));
}

void set_code(const SceneMesh& mesh, const py::object& code) { edit (&EditMesh::code)(mesh, code_of_python(code)); }

std::string described(const SceneMesh& mesh) {
  if (mesh.session->closed()) return "<simplexseg.SceneMesh of a closed session>";
  return read_mesh_item(mesh, [](const MeshItem& item) {
    return "<simplexseg.SceneMesh '" + item.name + "' of " + std::to_string(item.mesh.vertex_count()) + " vertices>";
  });
}

template <class Command>
void apply_command(const SceneMesh& mesh) {
  apply(*mesh.session, Command{mesh.id});
}

template <class Item>
void bind_identity(py::class_<Item>& item) {
  item.def("__eq__",
           [](const Item& one, const py::object& other) {
             return py::isinstance<Item>(other) && one == other.cast<const Item&>();
           })
      .def("__hash__", [](const Item& one) { return std::hash<const void*>()(one.session.get()) ^ one.id; })
      .def_property_readonly(
          "id", [](const Item& one) { return one.id; }, "Unique in a session, also in its logs.");
}

void bind_mesh_item(py::class_<SceneMesh>& item) {
  item.def_property("name", member_of(&MeshItem::name), &set_name, "Unique in the scene.")
      .def_property("label", member_of(&MeshItem::label), edit(&EditMesh::label), "Label of its voxels, 1 to 65535.")
      .def_property("visible", member_of(&MeshItem::visible), edit(&EditMesh::visible),
                    "Whether pictures and the window show it.")
      .def_property("locked", member_of(&MeshItem::locked), edit(&EditMesh::locked),
                    "Whether its pose, points, paint and range of intensities are fixed.")
      .def_property("opacity", member_of(&MeshItem::opacity), edit(&EditMesh::opacity),
                    "Opacity in 3D, above 0 and at most 1.")
      .def_property("colour", &colour_of, &set_colour, "Colour (red, green, blue), 0 to 255.")
      .def_property(
          "code", &code_of_mesh, &set_code,
          "Codes in DICOM files: category, type and modifier, each (scheme, value, meaning). They follow from "
          "the\n"
          "name by the label presets until they are set; {}: they follow from the name again.")
      .def_property(
          "intensity_range", &intensity_range_of, &set_intensity_range,
          "Intensities that its object can have, (lowest, highest); infinite: no limit. Others are background "
          "unless\nmarked or enclosed.")
      .def_property("model", &model_of, &set_model,
                    "Path of the model of its organ, a prior of the segmentation; None: no model.")
      .def_property_readonly("mesh", &surface_of, "Copy of its current shape, a Mesh.")
      .def_property_readonly(
          "points", [](const SceneMesh& mesh) { return points_of(mesh.session, mesh.id); },
          "Points of the mesh, in order of creation.")
      .def("get", &get_parameter, py::arg("name"),
           "Returns the value of forces.FORCE.PARAMETER: a number, or the name of a choice.")
      .def(
          "set",
          [](const SceneMesh& mesh, const std::string& name, const py::object& value) {
            set_parameter(*mesh.session, mesh.id, name, value);
          },
          py::arg("name"), py::arg("value"),
          "Sets forces.FORCE.PARAMETER to a number or to the name of a choice. Raises Error for an unknown name or a\n"
          "value out of range.")
      .def("add_point", &add_point, py::arg("position"), py::arg("kind") = "boundary", py::kw_only(),
           py::arg("radius") = 0.0, py::arg("outward") = py::none(), py::arg("path") = py::none(),
           py::arg("local") = false,
           "Adds a point and returns it. position: mm, LPS. kind: boundary (attracts the nearest part of the mesh), "
           "inside\n"
           "or outside. radius: radius of the marked ball, mm, 0 for the default. outward: outward direction of a\n"
           "boundary point, None for the normal of the surface nearby. path: further vertices of a stroke, mm, LPS, "
           "for\n"
           "an inside or outside point. local: changes the segmentation only near the point. Raises Error for a mark\n"
           "outside the volume.")
      .def("paint", &paint, py::arg("path"), py::arg("radius") = 0.0, py::kw_only(), py::arg("erase") = false,
           py::arg("normal") = py::none(), py::arg("thickness") = 0.0, py::arg("contour") = false,
           py::arg("edit") = py::none(),
           "Paints or erases voxels and returns the stroke: labels contain it exactly, and the mesh follows. path:\n"
           "vertices, mm, LPS. radius: mm. normal, thickness: of a slice, mm, for a disc in it instead of a ball.\n"
           "contour: the path encloses the voxels, in its slice or, with thickness 0, through the volume. edit:\n"
           "smart_paint (only voxels with the intensities of the path) or freeze (keeps the present voxels).")
      .def(
          "add_lasso", &add_lasso, py::arg("path"), py::arg("normal"), py::arg("kind") = "inside", py::kw_only(),
          py::arg("local") = false,
          "Adds a lasso and returns it: inside strokes in a closed contour and an outside stroke around it, or for "
          "kind\n"
          "outside, outside strokes in it. path: vertices, mm, LPS; normal: of its slice. Raises Error if it encloses\n"
          "nothing of the volume. local: it changes the segmentation only near it.")
      .def("edit_voxels", &edit_voxels, py::arg("edit"), py::kw_only(), py::arg("size") = py::none(),
           py::arg("other") = py::none(),
           "Changes the voxels of the object and returns the paint. edit: keep_largest, remove_small (size: mm3),\n"
           "fill_holes, margin (mm), smooth (standard deviation, mm), add, subtract or intersect (other: a mesh).\n"
           "Raises Error if no voxel would change.")
      .def("evidence", &evidence,
           "Foreground probability, computed from seed and points, as a Volume (float32) on its box of voxels; None "
           "until\n"
           "the first step that uses it.")
      .def("delete", &apply_command<DeleteMesh>, "Deletes the mesh and its points.")
      .def("reset", &apply_command<ResetPose>,
           "Resets the shape to its start: the sphere of the seed, or the initial labels.")
      .def("refine", &apply_command<RefineMesh>, "Refines the mesh: four times as many vertices.")
      .def("record_profiles", &apply_command<RecordProfiles>,
           "Records the current intensity profiles as the reference of the force intensity_profile.")
      .def(
          "duplicate",
          [](const SceneMesh& mesh) {
            return SceneMesh{{mesh.session, apply(*mesh.session, DuplicateMesh{mesh.id})}};
          },
          "Adds a copy with its shape and points; uses the first free name, label and colour.")
      .def("__repr__", [](const SceneMesh& mesh) { return python_text(described(mesh)); });
}

void bind_point_item(py::class_<ScenePoint>& item) {
  item.def_property_readonly(
          "position",
          [](const ScenePoint& point) {
            return tuple_of(read_point(point, [](const UserPoint& p) { return p.position_mm; }));
          },
          "Position in mm, LPS.")
      .def_property_readonly(
          "kind",
          [](const ScenePoint& point) { return name_of(read_point(point, [](const UserPoint& p) { return p.kind; })); },
          "Kind of the point: boundary, inside or outside.")
      .def_property_readonly(
          "radius",
          [](const ScenePoint& point) { return read_point(point, [](const UserPoint& p) { return p.radius_mm; }); },
          "Radius of the marked ball, or of the balls along a stroke, mm.")
      .def_property_readonly(
          "path",
          [](const ScenePoint& point) {
            py::list path;
            for (const Eigen::Vector3d& vertex : read_point(point, [](const UserPoint& p) { return p.vertices_mm(); }))
              path.append(tuple_of(vertex));
            return path;
          },
          "Vertices of a stroke or of the contour of a lasso, mm, LPS; the position alone for a point.")
      .def_property_readonly(
          "normal",
          [](const ScenePoint& point) -> py::object {
            const Eigen::Vector3d normal = read_point(point, [](const UserPoint& p) { return p.lasso_normal; });
            if (normal.norm() > 0) return tuple_of(normal);
            return py::none();
          },
          "Unit normal of the slice of a lasso; None for other points.")
      .def_property_readonly(
          "mesh",
          [](const ScenePoint& point) {
            return SceneMesh{{point.session, read_point(point, [](const UserPoint& p) { return p.mesh; })}};
          },
          "Mesh of the point.")
      .def(
          "move",
          [](const ScenePoint& point, const py::object& position) {
            apply(*point.session, MovePoint{point.id, vector_of(position, "position")});
          },
          py::arg("position"),
          "Moves the point to a position in mm, LPS. Raises Error for a mark outside the volume, and for a locked "
          "mesh.")
      .def(
          "resize",
          [](const ScenePoint& point, double radius) {
            apply(*point.session, ResizePoint{point.id, radius});
          },
          py::arg("radius"),
          "Sets the radius, mm, of an inside or outside point. Raises Error for a value out of range, and for a locked "
          "mesh.")
      .def(
          "delete", [](const ScenePoint& point) { apply(*point.session, DeletePoint{point.id}); },
          "Deletes the point. Raises Error for a locked mesh.");
}

}  // namespace

std::vector<SceneMesh> meshes_of(const std::shared_ptr<SessionOwner>& session) {
  return session->use([&](const Session& s) {
    std::vector<SceneMesh> meshes;
    for (const MeshItem& item : s.scene_without_poses().meshes) meshes.push_back({{session, item.id}});
    return meshes;
  });
}

std::vector<ScenePoint> points_of(const std::shared_ptr<SessionOwner>& session, ItemId mesh) {
  return session->use([&](const Session& s) {
    std::vector<ScenePoint> points;
    for (const UserPoint& item : s.scene_without_poses().points)
      if (mesh == 0 || item.mesh == mesh) points.push_back({{session, item.id}});
    return points;
  });
}

ItemId apply(SessionOwner& session, const Command& command) {
  return session.use([&](Session& s) { return s.apply(command); });
}

void set_parameter(SessionOwner& session, ItemId mesh, const std::string& name, const py::object& value) {
  const FoundParameter found = find_named(name);
  const float number = parameter_value(name, *found.info, value);
  if (found.force)
    apply(session, SetForceParameter{mesh, found.force->id, found.index, number});
  else if (mesh == 0)
    apply(session, SetSimulationParameter{found.index, number});
  else
    throw Error("parameter '" + name + "'", "it is not a parameter of a mesh", "use Session.set()");
}

void bind_items(py::module_& module) {
  py::class_<SceneMesh> mesh(
      module, "SceneMesh", "A mesh in the scene of a session. Raises Error after the mesh or the session is deleted.");
  py::class_<ScenePoint> point(module, "ScenePoint", "A point in the scene of a session. Raises Error like SceneMesh.");
  bind_identity(mesh);
  bind_identity(point);
  bind_mesh_item(mesh);
  bind_point_item(point);
}

}  // namespace simplexseg::python
