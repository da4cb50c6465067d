// SPDX-License-Identifier: Apache-2.0
#include "session/session.h"
#include "core/system_error.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <variant>

#include "app/simulate.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/files.h"
#include "io/scene/label_preset.h"
#include "io/scene/log_io.h"
#include "io/scene/measurement_export.h"
#include "io/scene/mesh_start.h"
#include "io/scene/scene_export.h"
#include "io/scene/scene_io.h"
#include "io/scene/set_by_path.h"
#include "io/volume/volume_checksum.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/interruptible.h"
#include "python/items.h"
#include "python/parameters.h"
#include "session/label_map.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

using Owner = std::shared_ptr<SessionOwner>;

LoadedInput input_of(const Image& image) {
  LoadedInput input;
  input.scene.simulation = default_simulation_parameters();
  input.scene.volume_path = image.path.string();
  input.scene.volume_number = image.number;
  input.scene.volume_series = image.series;
  input.scene.volume_checksum = checksum_of(image.volume);
  input.volume = image.volume;
  input.volume_path = image.path;
  input.low_is_bright = image.low_is_bright;
  return input;
}

Owner open_session(const std::variant<Image, fs::path>& source, const std::string& backend, int threads,
                   const py::object& parameters) {
  const std::vector<std::string> settings = settings_of(parameters);
  const fs::path* const path = std::get_if<fs::path>(&source);
  const bool is_scene = path && path->extension() == ".json";
  LoadedInput input = interruptible([&] {
    if (is_scene) return load_scene(*path, {.settings = settings, .history = LoadOptions::History::Read});
    LoadedInput made = path ? load_input(*path) : input_of(std::get<Image>(source));
    for (const std::string& setting : settings) set_by_path(made.scene, setting);
    return made;
  });
  const std::vector<std::string> warnings = std::move(input.warnings);
  Image image{input.volume, input.volume_path.empty() ? fs::path() : fs::absolute(input.volume_path),
              input.scene.volume_number, input.scene.volume_series, input.low_is_bright};
  Owner owner;
  {
    const WithoutGil released;
    owner = std::make_shared<SessionOwner>(is_scene ? path->string() : "", std::move(input), std::move(image), backend,
                                           threads);
  }
  warn(warnings);
  return owner;
}

SceneMesh add(const Owner& owner, const AddMesh& command) { return {{owner, apply(*owner, command)}}; }

ItemId id_of(const std::optional<SceneMesh>& mesh, const Owner& owner) {
  if (!mesh) return 0;
  if (mesh->session != owner) throw Error("like", "it is a mesh of another session", "use a mesh of this session");
  return mesh->id;
}

SceneMesh add_sphere(const Owner& owner, const py::str& name, const py::object& centre, double radius,
                     const std::optional<SceneMesh>& like) {
  return add(owner,
             {name.cast<std::string>(), {vector_of(centre, "centre"), radius}, std::nullopt, id_of(like, owner)});
}

SceneMesh add_lasso_start(const Owner& owner, const std::vector<py::object>& path, const py::object& normal,
                          const py::str& name, const std::optional<SceneMesh>& like) {
  AddMesh command{name.cast<std::string>(), {}, std::nullopt, id_of(like, owner)};
  if (path.empty()) throw Error("path", "it has no vertex", "give at least three positions");
  for (const py::object& vertex : path) command.contour_mm.emplace_back(vector_of(vertex, "path"));
  command.contour_normal = vector_of(normal, "normal").normalized();
  return add(owner, command);
}

SceneMesh add_start(const Owner& owner, const std::variant<Image, fs::path>& source, const py::str& name,
                    std::optional<double> label, int part, int vertices, const std::optional<SceneMesh>& like) {
  if (part < 0 || vertices < 0)
    throw Error("part or vertices", "it is negative", "use 0 for all parts or the default number");
  const ItemId like_id = id_of(like, owner);
  LoadedStart loaded = interruptible([&] {
    const Image* const labels = std::get_if<Image>(&source);
    if (labels) return start_of_labels(labels->volume, {label, part, {}}, labels->path.string(), vertices);
    return load_start({fs::absolute(std::get<fs::path>(source)).string(), label, part, {}}, {}, vertices);
  });
  warn(loaded.warnings);
  return add(owner, {name.cast<std::string>(), loaded.seed, std::nullopt, like_id, std::move(loaded.start)});
}

SceneMesh mesh_named(const Owner& owner, const std::string& name) {
  return owner->use([&](const Session& session) -> SceneMesh {
    if (const MeshItem* const item = session.scene_without_poses().find_mesh(name)) return {{owner, item->id}};
    throw Error("mesh '" + one_line(name) + "'", "no mesh has this name", "see Session.meshes");
  });
}

py::object get_parameter(SessionOwner& owner, const std::string& name) {
  const FoundParameter found = find_named(name);
  if (found.force) throw Error("parameter '" + name + "'", "each mesh has its own value", "use SceneMesh.get()");
  return python_value(*found.info, owner.use([&](const Session& session) {
    return value_of(session.scene_without_poses().simulation, found.index);
  }));
}

void require_steps(int steps) {
  if (steps < 0 || steps > kMaxSteps)
    throw Error("steps " + std::to_string(steps), "it is out of range", "use 0 to " + std::to_string(kMaxSteps));
}

Advance with_warnings(Advance advance) {
  warn(advance.warnings);
  return advance;
}

Advance run(SessionOwner& owner, std::optional<int> steps) {
  if (steps) require_steps(*steps);
  const int count =
      steps.value_or(owner.use([](const Session& session) { return session.scene_without_poses().steps; }));
  const bool until_rest = !steps && count == 0;
  return with_warnings(owner.run(until_rest ? kMaxStepsUntilRest : count, until_rest));
}

Advance run_until_rest(SessionOwner& owner, int most_steps) {
  require_steps(most_steps);
  return with_warnings(owner.run(most_steps, true));
}

Advance run_for(SessionOwner& owner, double seconds) {
  if (!(seconds >= 0 && std::isfinite(seconds)))
    throw Error("seconds", "it is negative or not finite", "use a time in seconds");
  return with_warnings(owner.run_for(seconds));
}

Image labels_of(SessionOwner& owner, const std::optional<Image>& like) {
  return {owner.use([&](const Session& session) {
    if (session.volume().empty())
      throw Error("labels", "the scene has no volume, so the grid of the labels is unknown", "use Mesh.rasterise()");
    const VolumeGeometry& grid = session.volume().geometry();
    return make_label_map(session.scene(), like ? like->volume.geometry() : grid, grid).labels;
  })};
}

void save_scene(SessionOwner& owner, const fs::path& path) {
  if (path.extension() != ".json")
    throw Error("cannot write " + quoted(path), "the name of a scene ends in .json", "rename it to NAME.json");
  owner.use([&](const Session& session) {
    const Scene& scene = session.scene();
    if (scene.volume_path.empty() && !session.volume().empty())
      throw Error("cannot write " + quoted(path), "its volume was created from an array and has no file",
                  "write the volume with write_volume() and open the session from that file");
    for (const MeshItem& item : scene.meshes)
      if (item.start && item.start->path.empty())
        throw Error("cannot write " + quoted(path),
                    "the initial labels of the mesh '" + one_line(item.name) + "' have no file",
                    "write the labels with write_labels() and use that file");
    write_scene(path, scene, session.history());
  });
}

void save_label_file(SessionOwner& owner, const fs::path& path) {
  const std::string note = owner.use([&](const Session& session) {
    if (session.volume().empty())
      throw Error("labels", "the scene has no volume, so the grid of the labels is unknown", "save meshes instead");
    require_labels_name(path, session.scene_without_poses());
    return save_labels(path, session.scene(), session.volume().geometry());
  });
  if (!note.empty()) warn({note});
}

std::vector<fs::path> save_mesh_files(SessionOwner& owner, const fs::path& folder, const std::string& format) {
  const std::string extension = "." + format;
  require_mesh_name(fs::path("mesh" + extension));
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (!fs::is_directory(folder))
    throw Error("cannot create the folder " + quoted(folder),
                failure ? system_error_text(failure) : "a file has this name", "choose another name");
  return owner.use([&](const Session& session) { return save_meshes(folder, session.scene(), extension); });
}

void save_log(SessionOwner& owner, const fs::path& path) {
  owner.use([&](const Session& session) {
    write_log(path, session.log(), session.steps_since_last_command(), owner.scene_path());
  });
}

void save_measurement_file(SessionOwner& owner, const fs::path& path) {
  const std::string note = owner.use([&](const Session& session) {
    require_measurement_name(path, session.scene_without_poses());
    return save_measurements(path, session.scene(), session.volume(), owner.intensity_unit());
  });
  if (!note.empty()) warn({note});
}

template <class Command>
bool undo_or_redo(SessionOwner& owner, bool (Session::*possible)() const) {
  return owner.use([&](Session& session) {
    if (!(session.*possible)()) return false;
    session.apply(Command{});
    return true;
  });
}

std::optional<Image> volume_of_session(const SessionOwner& owner) {
  if (owner.image().volume.empty()) return std::nullopt;
  return owner.image();
}

/// Returns a getter for a property of the session.
void set_label_preset(SessionOwner& owner, const py::str& name_or_path) {
  const std::string name = name_or_path.cast<std::string>();
  ChooseLabelPreset command;
  if (!name.empty()) {
    const LabelPreset preset = find_label_preset(name);
    command = {preset.name, preset.by_name()};
  }
  apply(owner, command);
}

template <class Read>
auto reading(Read read) {
  return [read](SessionOwner& owner) { return owner.use([&](const Session& session) { return read(session); }); };
}

using SessionClass = py::class_<SessionOwner, Owner>;

void bind_scene(SessionClass& session) {
  session.def_property_readonly("volume", &volume_of_session, "Volume of the session; None if the scene has no volume.")
      .def_property_readonly(
          "meshes", [](const Owner& owner) { return meshes_of(owner); }, "Meshes, in the order of the scene.")
      .def_property_readonly(
          "points", [](const Owner& owner) { return points_of(owner); }, "Points of all meshes.")
      .def_property(
          "label_preset",
          [](SessionOwner& owner) {
            return python_text(owner.use([](const Session& s) { return s.scene_without_poses().labels.preset; }));
          },
          &set_label_preset,
          "Label preset, a name of label_presets() or a file: a mesh with a name of the preset has the label of that "
          "name.\n"
          "\"\": none.")
      .def_property_readonly(
          "measurements", [](const Owner& owner) { return measurements_of(owner); }, "Rulers, angles and ellipses.")
      .def("add_measurement", &add_measurement, py::arg("kind"), py::arg("points"), py::kw_only(), py::arg("name") = "",
           "Adds a measurement and returns it. kind: ruler, angle or ellipse; points: mm, LPS, see "
           "SceneMeasurement.points;\n"
           "name: \"\" for the first free \"ruler N\". Raises Error for points that are not of this kind.")
      .def_property_readonly(
          "layers", [](const Owner& owner) { return layers_of(owner); }, "Further images, in the order of the scene.")
      .def("add_layer", &add_layer, py::arg("path"), py::kw_only(), py::arg("name") = "",
           py::arg("transform") = py::none(),
           "Adds an image or DICOM folder as a layer and returns it. name: \"\" for that of the series or the file; "
           "transform:\n"
           "file with a transform from points of the volume to points of the image. Raises Error for files that cannot "
           "be\n"
           "read.")
      .def("mesh", &mesh_named, py::arg("name"), "Returns the mesh with this name. Raises Error if there is none.")
      .def("add_mesh", &add_sphere, py::arg("name") = "", py::kw_only(), py::arg("centre"), py::arg("radius"),
           py::arg("like") = py::none(),
           "Adds a mesh that starts as a sphere and grows during a run. centre, radius: mm, LPS; name: \"\" for the "
           "first\n"
           "free \"mesh N\"; like: mesh whose parameters are copied. Raises Error if the centre is outside the volume.")
      .def(
          "add_mesh_from_lasso", &add_lasso_start, py::arg("path"), py::arg("normal"), py::arg("name") = "",
          py::kw_only(), py::arg("like") = py::none(),
          "Adds a mesh that starts from a closed contour around the structure in a slice: a seed in it, and an inside\n"
          "lasso. path: vertices, mm, LPS; normal: of the slice; name, like: see add_mesh(). Raises Error if the "
          "contour\n"
          "encloses nothing of the volume.")
      .def("add_mesh_from", &add_start, py::arg("source"), py::arg("name") = "", py::kw_only(),
           py::arg("label") = py::none(), py::arg("part") = 0, py::arg("vertices") = 0, py::arg("like") = py::none(),
           "Adds a mesh that starts from labels or from a mesh file. source: a label Volume, a label file or a mesh "
           "file;\n"
           "label: None for all voxels that are not 0; part: number of the connected part, 1 for the largest, 0 for "
           "all;\n"
           "vertices: approximate number, 0 for the default; name, like: see add_mesh(). Raises Error.")
      .def("get", &get_parameter, py::arg("name"),
           "Returns the value of simulation.PARAMETER: a number, or the name of a choice.")
      .def(
          "set",
          [](SessionOwner& owner, const std::string& name, const py::object& value) {
            set_parameter(owner, 0, name, value);
          },
          py::arg("name"), py::arg("value"),
          "Sets simulation.PARAMETER, or forces.FORCE.PARAMETER of all existing meshes, to a number or to the name of "
          "a\n"
          "choice. Raises Error for an unknown name or a value out of range.")
      .def(
          "undo", [](SessionOwner& owner) { return undo_or_redo<Undo>(owner, &Session::can_undo); },
          "Undoes the last change of the scene, including poses. Returns False if there is nothing to undo.")
      .def(
          "redo", [](SessionOwner& owner) { return undo_or_redo<Redo>(owner, &Session::can_redo); },
          "Redoes the last undone change. Returns False if there is nothing to redo.")
      .def_property_readonly("can_undo", reading([](const Session& s) { return s.can_undo(); }),
                             "Whether there is a change to undo.")
      .def_property_readonly("can_redo", reading([](const Session& s) { return s.can_redo(); }),
                             "Whether there is a change to redo.")
      .def_property_readonly("undo_title", reading([](const Session& s) { return std::string(s.undo_title()); }),
                             "Name of the change that undo() reverts; \"\" if there is none.");
}

void bind_running(SessionClass& session) {
  session
      .def("run", &run, py::arg("steps") = py::none(),
           "Runs steps. steps: None for the steps of the scene, or until the meshes settle if the scene has 0, like\n"
           "`simplexseg-cli run`. Other Python threads run meanwhile; Ctrl+C stops between two steps, and the session\n"
           "remains usable. Issues a DataWarning for each problem of a segmentation. Raises SimulationError if a step\n"
           "fails at every timestep.")
      .def("run_until_rest", &run_until_rest, py::arg("most_steps") = kMaxStepsUntilRest,
           "Runs until the meshes settle (at_rest is True), at most most_steps. Otherwise like run().")
      .def("run_for", &run_for, py::arg("seconds"),
           "Runs for a time, or until the meshes settle. Like run(), but fields are solved in parallel with the steps, "
           "so\n"
           "two runs may differ in the last digits; the log reproduces a run exactly.")
      .def_property_readonly("steps", reading([](const Session& s) { return s.total_steps(); }),
                             "Number of steps since the session was opened.");
}

void bind_results(SessionClass& session) {
  session
      .def("labels", &labels_of, py::arg("like") = py::none(),
           "Returns the label map of the meshes on the grid of the volume, or of the volume `like` (uint8, or uint16 "
           "for\n"
           "labels above 255). Raises Error if the scene has no volume.")
      .def("save_scene", &save_scene, py::arg("path"),
           "Writes the scene (.json) with its meshes and undo history, to continue it here or in the window.")
      .def("save_labels", &save_label_file, py::arg("path"),
           "Writes labels (.nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .dcm, .labelmap.dcm) or contours (.rtstruct.dcm). "
           "Issues a "
           "DataWarning\n"
           "if meshes overlap. Raises Error if the file cannot be written.")
      .def("save_meshes", &save_mesh_files, py::arg("folder"), py::arg("format") = "ply",
           "Writes each mesh to NAME.ply (or obj, stl, vtk, vtp, 3mf, glb) in a folder, which is created. Returns the "
           "files.")
      .def("save_report", &SessionOwner::save_report, py::arg("path"),
           "Writes a report (JSON) of the runs and meshes, with their agreement with the references of the scene.")
      .def("save_picture", &SessionOwner::save_picture, py::arg("path"),
           "Writes a picture (.png, .ppm) of three slices with the outlines of the meshes.")
      .def("save_measurements", &save_measurement_file, py::arg("path"),
           "Writes the measurements, and volume, intensities, long and short axis of each mesh: a table (.csv), or a "
           "DICOM structured report with its segmentation (NAME.sr.dcm and NAME.seg.dcm). Issues a warning if "
           "segmentations overlap in voxels.")
      .def("save_log", &save_log, py::arg("path"),
           "Writes the log of commands and steps, for `simplexseg-cli run SCENE --replay`.");
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<Advance>(module, "RunResult", "Result of a run.")
      .def_readonly("steps", &Advance::steps, "Number of steps.")
      .def_readonly("seconds", &Advance::seconds, "Time of the simulation, s.")
      .def_readonly("at_rest", &Advance::at_rest, "Whether all meshes have settled.")
      .def_property_readonly(
          "warnings", [](const Advance& a) { return python_texts(a.warnings); },
          "Problems of segmentations (leaking, probably wrong, ranges without effect) and failures of the device, one "
          "line each.")
      .def_property_readonly(
          "timestep_cuts", [](const Advance& a) { return python_texts(a.cuts); },
          "Steps that were repeated with a smaller timestep, one line each.")
      .def("__repr__", [](const Advance& a) {
        return "<simplexseg.RunResult of " + std::to_string(a.steps) + " steps" + (a.at_rest ? ", settled>" : ">");
      });

  SessionClass session(module, "Session",
                       "A scene on a volume, and its simulation. Only one thread at a time may use a session; several\n"
                       "sessions can run in parallel. As a context manager, it closes at the end of the block.");
  session
      .def(
          py::init(&open_session), py::arg("source"), py::kw_only(), py::arg("backend") = "auto",
          py::arg("threads") = 0, py::arg("settings") = py::dict(),
          "source: a Volume, a scene (.json), a volume file or a DICOM folder. backend: cpu, cuda, or auto (CUDA if a\n"
          "device is available); threads: CPU threads, 0 for all cores. settings: parameters by name, like --set of\n"
          "`simplexseg-cli run`, for existing and future meshes. Raises Error.")
      .def("close", &SessionOwner::close, "Releases all memory; any further use raises Error.")
      .def(
          "__enter__", [](const Owner& owner) { return owner; }, "Returns the session.")
      .def(
          "__exit__", [](SessionOwner& owner, const py::args&) { owner.close(); }, "Closes the session.")
      .def_property_readonly("closed", &SessionOwner::closed, "Whether close() was called.")
      .def_property_readonly("backend", reading([](const Session& s) { return std::string(s.engine().backend()); }),
                             "Backend in use: cpu or cuda.")
      .def_property_readonly("device", reading([](const Session& s) { return s.engine().description(); }),
                             "Description of the device and its threads.")
      .def("__repr__", [](const SessionOwner& owner) {
        return owner.closed() ? "<simplexseg.Session, closed>" : "<simplexseg.Session>";
      });
  bind_scene(session);
  bind_running(session);
  bind_results(session);
}

}  // namespace simplexseg::python
