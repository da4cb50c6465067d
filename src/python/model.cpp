// SPDX-License-Identifier: Apache-2.0
// Models of organs.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <thread>

#include "core/error.h"
#include "core/thread_pool.h"
#include "io/model/train_from_table.h"
#include "io/platform/load_progress.h"
#include "model/model_start.h"
#include "model/template_registration.h"
#include "python/arrays.h"
#include "python/bindings.h"
#include "python/gil.h"
#include "python/image.h"
#include "python/interruptible.h"
#include "python/mesh.h"

namespace simplexseg::python {
namespace {

namespace fs = std::filesystem;

struct TrainedModel {
  std::shared_ptr<const ModelFile> file;
  const OrganModel& organ() const { return file->organs.front(); }
};

TrainedModel trained(ModelFile file) { return {std::make_shared<const ModelFile>(std::move(file))}; }

TrainedModel train(const fs::path& table, const std::optional<fs::path>& add, const std::string& name,
                   const std::string& modality, int vertices, int modes, bool curve, int threads) {
  if (vertices < 0 || vertices > 20000) throw Error("vertices", "it is out of range", "use 0 to 20000");
  if (modes < 1 || modes > 1000) throw Error("modes", "it is out of range", "use 1 to 1000");
  if (threads < 0 || threads > 1024) throw Error("threads", "it is out of range", "use 0 to 1024");
  TrainedTable result = interruptible([&] {
    TableTraining training;
    training.rows = read_case_table(table);
    training.name = name, training.modality = modality;
    training.settings.vertices = vertices, training.settings.modes = modes, training.settings.measure_curve = curve;
    if (add) training.add_to = *add;
    ThreadPool pool(threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
    return train_from_table(
        training, [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); },
        [](double share) { report_progress(share, 1); });
  });
  warn(result.warnings);
  // The checksum is that of a written file.
  return trained(model_from_bytes(model_bytes(result.file), "(trained)"));
}

void save(const TrainedModel& model, const fs::path& path) {
  ModelFile copy = *model.file;
  write_model(path, copy);
}

Surface shape(const TrainedModel& model, const std::vector<double>& coefficients) {
  const ShapeModel& organ = model.organ().shape;
  if (static_cast<int>(coefficients.size()) > organ.mode_count())
    throw Error("coefficients", "there are more than the " + std::to_string(organ.mode_count()) + " modes of the model",
                "use one value, in standard deviations, for each of the first modes");
  Eigen::VectorXd all = Eigen::VectorXd::Zero(organ.mode_count());
  for (std::size_t k = 0; k < coefficients.size(); ++k) {
    if (!std::isfinite(coefficients[k])) throw Error("coefficients", "a value is not finite", "use finite numbers");
    all[static_cast<Eigen::Index>(k)] = coefficients[k];
  }
  return Surface(mesh_at(organ.mean, shape_of(organ, all)));
}

py::object find(const TrainedModel& model, const Image& image) {
  std::optional<Mark> seed;
  {
    const WithoutGil released;
    ThreadPool pool(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
    seed = find_organ(model.organ(), image.volume,
                      [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); });
  }
  if (!seed) return py::none();
  return py::make_tuple(tuple_of(seed->position_mm), seed->radius_mm);
}

}  // namespace

void bind_model(py::module_& module) {
  py::class_<TrainedModel>(module, "Model",
                           "Statistical model of the shape and the intensity profiles of an organ. Immutable.")
      .def(py::init([](const fs::path& path) { return trained(interruptible([&] { return read_model(path); })); }),
           py::arg("path"), "Reads a model file. Raises Error for a file that is missing, damaged or no model.")
      .def_static(
          "train", &train, py::arg("table"), py::kw_only(), py::arg("add") = py::none(), py::arg("name") = "",
          py::arg("modality") = "", py::arg("vertices") = 0, py::arg("modes") = 60, py::arg("curve") = false,
          py::arg("threads") = 0,
          "Trains a model from the cases of a table, as simplexseg-cli model train. table: CSV file with the columns\n"
          "image, labels, label, mirror, name; add: model file to which the cases are added; vertices: of the "
          "template,\n"
          "0: chosen; modes: largest number; curve: measure the error for fewer cases too; threads: 0 for all cores.\n"
          "Raises Error for bad input.")
      .def("save", &save, py::arg("path"), py::call_guard<WithoutGil>(),
           "Writes a model file. Raises Error if the file cannot be written.")
      .def_property_readonly(
          "name", [](const TrainedModel& m) { return py::str(m.organ().name); }, "Name of the organ; \"\": not given.")
      .def_property_readonly(
          "modality", [](const TrainedModel& m) { return py::str(m.organ().modality); },
          "Modality of the images; \"\": not given.")
      .def_property_readonly(
          "checksum", [](const TrainedModel& m) { return m.file->checksum; }, "Checksum of the contents of the file.")
      .def_property_readonly(
          "cases", [](const TrainedModel& m) { return m.organ().cases.size(); }, "Number of training cases.")
      .def_property_readonly(
          "error_mm", [](const TrainedModel& m) { return m.organ().surface_error_mm; },
          "Root mean square normal error of instances in cases that the model had not seen, mm.")
      .def_property_readonly(
          "explained_variance",
          [](const TrainedModel& m) {
            const Eigen::VectorXd variances = mode_variances(m.organ().shape);
            const double sum = variances.sum();
            return py::array_t<double>(variances.size(), Eigen::VectorXd(variances / (sum > 0 ? sum : 1)).data());
          },
          "Share of each mode of the variance of all modes, in decreasing order, float64.")
      .def_property_readonly(
          "mean", [](const TrainedModel& m) { return Surface(m.organ().shape.mean); },
          "Mean shape as a Mesh, centred at (0, 0, 0), in the mean size and orientation.")
      .def_property_readonly(
          "registered",
          [](const TrainedModel& m) {
            py::list all;
            for (const TrainedCase& one : m.organ().cases) all.append(array_of(one.points.transpose()));
            return all;
          },
          "Vertices of the template registered to each training case, as a list of V x 3 arrays, mm, LPS, float64: "
          "equal\n"
          "rows are at corresponding places, in the order of the vertices of `mean`. V is 0 for a model of an earlier\n"
          "version. A mirrored case is in the frame of the mirrored image.")
      .def("shape", &shape, py::arg("coefficients"),
           "Returns the mean shape deformed by the first modes, as a Mesh with the connectivity of `mean`. "
           "coefficients:\n"
           "one value for each of these modes, in standard deviations. Raises Error for too many values.")
      .def("find", &find, py::arg("volume"),
           "Returns the seed (centre, radius) at which the model finds its organ in a volume, mm, or None if it does "
           "not\n"
           "recognise the organ, or the volume has another field of view than the training.")
      .def("__repr__", [](const TrainedModel& m) {
        const OrganModel& organ = m.organ();
        return "<simplexseg.Model '" + organ.name + "', " + std::to_string(organ.cases.size()) + " cases, " +
               std::to_string(organ.shape.mode_count()) + " modes>";
      });
}

}  // namespace simplexseg::python
