// SPDX-License-Identifier: Apache-2.0
#include "session/session.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <variant>

#include "cli/simulate.h"
#include "io/files.h"
#include "io/log_io.h"
#include "io/mesh_io.h"
#include "io/mesh_start.h"
#include "io/scene_export.h"
#include "io/scene_io.h"
#include "io/set_by_path.h"
#include "io/volume_checksum.h"
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
                   const py::object& named) {
  const std::vector<std::string> settings = settings_of(named);
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
  if (mesh->session != owner) throw Error("like", "it is a mesh of another session", "give one of this");
  return mesh->id;
}

SceneMesh add_sphere(const Owner& owner, const py::str& name, const py::object& centre, double radius,
                     const std::optional<SceneMesh>& like) {
  return add(owner,
             {name.cast<std::string>(), {vector_of(centre, "centre"), radius}, std::nullopt, id_of(like, owner)});
}

SceneMesh add_start(const Owner& owner, const std::variant<Image, fs::path>& source, const py::str& name,
                    std::optional<double> label, int part, int vertices, const std::optional<SceneMesh>& like) {
  if (part < 0 || vertices < 0) throw Error("part or vertices", "it is below 0", "give 0 for all, or as many as suit");
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
    throw Error("mesh '" + one_line(name) + "'", "the scene has none of that name", "see Session.meshes");
  });
}

py::object get_parameter(SessionOwner& owner, const std::string& name) {
  const FoundParameter found = find_named(name);
  if (found.force) throw Error("parameter '" + name + "'", "each mesh has its own", "ask a mesh for it");
  return python_value(*found.info, owner.use([&](const Session& session) {
    return value_of(session.scene_without_poses().simulation, found.index);
  }));
}

void require_steps(int steps) {
  if (steps < 0 || steps > kMostSteps)
    throw Error("steps " + std::to_string(steps), "it is out of range", "give 0 to " + std::to_string(kMostSteps));
}

Advance warned(Advance advance) {
  warn(advance.warnings);
  return advance;
}

Advance run(SessionOwner& owner, std::optional<int> steps) {
  if (steps) require_steps(*steps);
  const int wanted =
      steps.value_or(owner.use([](const Session& session) { return session.scene_without_poses().steps; }));
  const bool until_rest = !steps && wanted == 0;
  return warned(owner.run(until_rest ? kMostStepsUntilRest : wanted, until_rest));
}

Advance run_until_rest(SessionOwner& owner, int most_steps) {
  require_steps(most_steps);
  return warned(owner.run(most_steps, true));
}

Advance run_for(SessionOwner& owner, double seconds) {
  if (!(seconds >= 0 && std::isfinite(seconds))) throw Error("seconds", "it is below 0 or not finite", "give seconds");
  return warned(owner.run_for(seconds));
}

Image labels_of(SessionOwner& owner) {
  return {owner.use([](const Session& session) {
    if (session.volume().empty())
      throw Error("labels", "the scene names no volume, so there is no grid for them",
                  "rasterise a mesh onto a volume");
    return make_label_map(session.scene(), session.volume().geometry()).labels;
  })};
}

void save_scene(SessionOwner& owner, const fs::path& path) {
  if (path.extension() != ".json")
    throw Error("cannot write " + quoted(path), "the name of a scene ends in .json", "rename it");
  owner.use([&](const Session& session) {
    const Scene& scene = session.scene();
    if (scene.volume_path.empty() && !session.volume().empty())
      throw Error("cannot write " + quoted(path), "its volume was made of an array and has no file to be named",
                  "write it with write_volume() and open the session from that file");
    for (const MeshItem& item : scene.meshes)
      if (item.start && item.start->path.empty())
        throw Error("cannot write " + quoted(path),
                    "the labels that mesh '" + one_line(item.name) + "' starts from have no file to be named",
                    "write them with write_labels() and give that file");
    write_scene(path, scene, session.history());
  });
}

void save_label_file(SessionOwner& owner, const fs::path& path) {
  const std::string note = owner.use([&](const Session& session) {
    if (session.volume().empty())
      throw Error("labels", "the scene names no volume, so there is no grid for them", "save meshes instead");
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
    throw Error("cannot make the folder " + quoted(folder),
                failure ? failure.message() : "there is a file of that name", "name another");
  return owner.use([&](const Session& session) { return save_meshes(folder, session.scene(), extension); });
}

void save_log(SessionOwner& owner, const fs::path& path) {
  owner.use([&](const Session& session) {
    write_log(path, session.log(), session.steps_since_last_command(), owner.scene_path());
  });
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

/// A property that is read off the session.
template <class Read>
auto reading(Read read) {
  return [read](SessionOwner& owner) { return owner.use([&](const Session& session) { return read(session); }); };
}

using SessionClass = py::class_<SessionOwner, Owner>;

void bind_scene(SessionClass& session) {
  session.def_property_readonly("volume", &volume_of_session, "As it was opened; None where the scene names none.")
      .def_property_readonly(
          "meshes", [](const Owner& owner) { return meshes_of(owner); }, "In the order of the scene.")
      .def_property_readonly(
          "points", [](const Owner& owner) { return points_of(owner); }, "Of all meshes.")
      .def("mesh", &mesh_named, py::arg("name"), "The mesh of that name. Raises Error where there is none.")
      .def(
          "add_mesh", &add_sphere, py::arg("name") = "", py::kw_only(), py::arg("centre"), py::arg("radius"),
          py::arg("like") = py::none(),
          "A sphere, centre and radius in mm (LPS), that grows once it runs. name: \"\" for the first \"mesh N\" that\n"
          "is free; like: a mesh whose parameters it takes. Raises Error for a centre outside of the volume.")
      .def(
          "add_mesh_from", &add_start, py::arg("source"), py::arg("name") = "", py::kw_only(),
          py::arg("label") = py::none(), py::arg("part") = 0, py::arg("vertices") = 0, py::arg("like") = py::none(),
          "A mesh that starts from labels, or from the mesh of a file. source: a label Volume, a label file or a mesh\n"
          "file; label: None for every voxel that is not 0; part: a connected part of it, 1 the largest, 0 all;\n"
          "vertices: about so many, 0 for as many as suit. Raises Error.")
      .def("get", &get_parameter, py::arg("name"), "The value of simulation.PARAMETER; a choice by its name.")
      .def(
          "set",
          [](SessionOwner& owner, const std::string& name, const py::object& value) {
            set_parameter(owner, 0, name, value);
          },
          py::arg("name"), py::arg("value"),
          "Sets simulation.PARAMETER, or forces.FORCE.PARAMETER of every mesh that there is, to a number or the name\n"
          "of a choice. Raises Error for an unknown name or a value out of range.")
      .def(
          "undo", [](SessionOwner& owner) { return undo_or_redo<Undo>(owner, &Session::can_undo); },
          "Takes the last change of the scene back, poses included; False where there is none.")
      .def(
          "redo", [](SessionOwner& owner) { return undo_or_redo<Redo>(owner, &Session::can_redo); },
          "Does it again; False where there is none.")
      .def_property_readonly("can_undo", reading([](const Session& s) { return s.can_undo(); }),
                             "Whether undo() would.")
      .def_property_readonly("can_redo", reading([](const Session& s) { return s.can_redo(); }),
                             "Whether redo() would.")
      .def_property_readonly("undo_title", reading([](const Session& s) { return std::string(s.undo_title()); }),
                             "What undo() takes back, in words; \"\" where there is nothing.");
}

void bind_running(SessionClass& session) {
  session
      .def("run", &run, py::arg("steps") = py::none(),
           "Takes so many steps; None: those of the scene, or until rest where they are 0, as `simplexseg-cli run`.\n"
           "Other Python threads go on; Ctrl+C ends it between two steps, and the session can go on. What is noticed\n"
           "of a mesh is a DataWarning. Raises SimulationError where steps fail that no smaller timestep helps.")
      .def("run_until_rest", &run_until_rest, py::arg("most_steps") = kMostStepsUntilRest,
           "Steps until nothing moves, or so many are done: at_rest says which. As run().")
      .def("run_for", &run_for, py::arg("seconds"),
           "As many steps as fit into the time, or until rest. As run(), but fields are learned beside the steps, so\n"
           "that two runs need not be the same to the bit; the log says what was done.")
      .def_property_readonly("steps", reading([](const Session& s) { return s.total_steps(); }),
                             "Steps since the session was opened.");
}

void bind_results(SessionClass& session) {
  session
      .def("labels", &labels_of,
           "The voxels inside each mesh, with its label, on the volume's grid (uint8, or uint16 where a label needs "
           "it).\n"
           "Raises Error without a volume.")
      .def("save_scene", &save_scene, py::arg("path"),
           "Writes the scene with its meshes and what can be undone (.json), to be run on or opened in the window.")
      .def("save_labels", &save_label_file, py::arg("path"),
           "Writes labels (.nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .dcm) or contours (.rtstruct.dcm). Voxels that two\n"
           "meshes share are a DataWarning. Raises Error.")
      .def("save_meshes", &save_mesh_files, py::arg("folder"), py::arg("format") = "ply",
           "Writes each mesh as NAME.ply, or obj, stl, vtk or vtp, into the folder, which is made; returns the files.")
      .def("save_report", &SessionOwner::save_report, py::arg("path"),
           "Writes what was run and found, with the agreement with the scene's references, as JSON.")
      .def("save_picture", &SessionOwner::save_picture, py::arg("path"),
           "Writes three slices with the meshes' outlines (.png, .ppm).")
      .def("save_log", &save_log, py::arg("path"),
           "Writes what was done and after how many steps, for `simplexseg-cli run SCENE --replay`.");
}

}  // namespace

void bind_session(py::module_& module) {
  py::class_<Advance>(module, "RunResult", "What a run did.")
      .def_readonly("steps", &Advance::steps, "Steps taken.")
      .def_readonly("seconds", &Advance::seconds, "Time of the simulation alone.")
      .def_readonly("at_rest", &Advance::at_rest, "Whether nothing moves any more.")
      .def_property_readonly(
          "warnings", [](const Advance& a) { return python_texts(a.warnings); },
          "Of meshes that leak or are unsure of their object, and of a device that failed.")
      .def_property_readonly(
          "timestep_cuts", [](const Advance& a) { return python_texts(a.cuts); },
          "A line for each step that was undone and taken again with a smaller timestep.")
      .def("__repr__", [](const Advance& a) {
        return "<simplexseg.RunResult of " + std::to_string(a.steps) + " steps" + (a.at_rest ? ", at rest>" : ">");
      });

  SessionClass session(module, "Session",
                       "A scene on a volume, and its simulation. One thread at a time uses it; several sessions run\n"
                       "beside each other. with Session(...) closes it.");
  session
      .def(
          py::init(&open_session), py::arg("source"), py::kw_only(), py::arg("backend") = "auto",
          py::arg("threads") = 0, py::arg("settings") = py::dict(),
          "source: a Volume, a scene (.json), a volume file or a DICOM folder. backend: auto (CUDA where a device can\n"
          "be used), cpu or cuda; threads: of the CPU, 0 for as many as the machine has. settings: parameters by\n"
          "name, as --set of `simplexseg-cli run`, for the meshes that there are and those to come. Raises Error.")
      .def("close", &SessionOwner::close, "Lets go of its memory; whatever is asked of it then raises Error.")
      .def(
          "__enter__", [](const Owner& owner) { return owner; }, "The session itself.")
      .def(
          "__exit__", [](SessionOwner& owner, const py::args&) { owner.close(); }, "Closes it.")
      .def_property_readonly("closed", &SessionOwner::closed, "Whether close() was called.")
      .def_property_readonly("backend", reading([](const Session& s) { return std::string(s.engine().backend()); }),
                             "cpu or cuda.")
      .def_property_readonly("device", reading([](const Session& s) { return s.engine().description(); }),
                             "Device and threads, in words.")
      .def("__repr__", [](const SessionOwner& owner) {
        return owner.closed() ? "<simplexseg.Session, closed>" : "<simplexseg.Session>";
      });
  bind_scene(session);
  bind_running(session);
  bind_results(session);
}

}  // namespace simplexseg::python
