// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>
#include <thread>

#include "app/load.h"
#include "app/model_pictures.h"
#include "app/progress.h"
#include "app/table.h"
#include "cli/commands.h"
#include "core/number_text.h"
#include "core/thread_pool.h"
#include "io/model/train_from_table.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "model/learning_curve.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

struct TrainOptions {
  TableTraining training;
  std::string table, out, add, scale = "auto";
  int threads = 0;
  bool json = false;
};

/// Reports of the cases of an organ, in the order of its last cases.
std::vector<CaseReport> cases_of(const TrainedTable& trained, std::size_t organ) {
  std::vector<CaseReport> cases;
  for (const CaseReport& one : trained.cases)
    if (one.organ == static_cast<int>(organ)) cases.push_back(one);
  return cases;
}

Json organ_json(const TrainedTable& trained, std::size_t number) {
  const OrganModel& organ = trained.file.organs[number];
  const std::vector<CaseReport> reports = cases_of(trained, number);
  Json cases = Json::array();
  for (std::size_t c = 0; c < reports.size(); ++c) {
    const CaseReport& one = reports[c];
    const TrainedCase& data = organ.cases[organ.cases.size() - reports.size() + c];
    Json& row = cases.emplace_back(Json{{"name", one.name},
                                        {"image", one.source.image},
                                        {"labels", one.source.labels},
                                        {"distance_mm", one.distance_mm},
                                        {"folded", one.folded},
                                        {"error_mm", nullptr},
                                        {"error_cases", data.error_cases}});
    if (data.error_cases > 0) row["error_mm"] = data.error_mm;
  }
  return {{"cases", organ.cases.size()},
          {"vertices", organ.shape.vertex_count()},
          {"modes", organ.shape.mode_count()},
          {"error_mm", organ.surface_error_mm},
          {"trained", cases}};
}

void print_json(const TrainedTable& trained, std::ostream& out) {
  Json json{{"checksum", trained.file.checksum}};
  if (trained.file.organs.size() == 1) {
    json.update(organ_json(trained, 0));
  } else {
    json["organs"] = Json::array();
    for (std::size_t k = 0; k < trained.file.organs.size(); ++k) {
      Json& organ = json["organs"].emplace_back(Json{{"name", trained.file.organs[k].name}});
      organ.update(organ_json(trained, k));
    }
  }
  out << json.dump(1) << "\n";
}

void print_text(const TrainedTable& trained, double seconds, std::ostream& out) {
  for (std::size_t k = 0; k < trained.file.organs.size(); ++k) {
    const OrganModel& organ = trained.file.organs[k];
    if (trained.file.organs.size() > 1) out << "organ      " << organ.name << "\n";
    std::vector<std::vector<std::string>> table{{"case", "distance mm", "folded vertices"}};
    for (const CaseReport& one : cases_of(trained, k))
      table.push_back({one.name, fixed_or_dash(one.distance_mm, 3), std::to_string(one.folded)});
    print_table(out, table, 1);
    out << "cases      " << organ.cases.size() << "\nvertices   " << organ.shape.vertex_count() << "\nmodes      "
        << organ.shape.mode_count() << "\nintensity  "
        << (organ.profiles.scale == IntensityScale::Hounsfield ? "Hounsfield units" : "percentiles") << "\nerror      "
        << length_text(organ.surface_error_mm) << " (root mean square, cases left out)\n";
  }
  out << "checksum   " << trained.file.checksum << "\ntime       " << fixed_or_dash(seconds, 1) << " s\n";
}

void train(const TrainOptions& options, const Console& console) {
  OutputChecks({options.table}).require_file(options.out);
  TableTraining training = options.training;
  training.rows = read_case_table(options.table);
  training.add_to = options.add;
  if (options.scale != "auto")
    training.scale = options.scale == "hounsfield" ? IntensityScale::Hounsfield : IntensityScale::Percentiles;
  const int threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  ThreadPool pool(threads);
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  const auto begin = std::chrono::steady_clock::now();
  TrainedTable trained;
  {
    const Interrupt interrupt;
    Progress progress(console, "training");
    trained = train_from_table(training, run, [&](double share) {
      Interrupt::check();
      progress.set(share);
    });
    write_model(options.out, trained.file);
  }
  print_warnings(trained.warnings, console);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  if (options.json)
    print_json(trained, console.out);
  else
    print_text(trained, seconds, console.out);
}

constexpr double kNeededShare = 0.1;  ///< difference of an error from its limit that more cases are not needed for

void show(const std::string& path, const std::string& pictures, const Console& console) {
  if (!pictures.empty()) OutputChecks({path}).require_folder(pictures);
  const ModelFile file = read_model(path);
  if (!pictures.empty()) {
    make_folder(pictures);
    if (file.organs.size() == 1) write_model_pictures(file.organs[0], pictures);
    for (std::size_t k = 0; file.organs.size() > 1 && k < file.organs.size(); ++k) {
      const std::string folder = (std::filesystem::path(pictures) / ("organ_" + std::to_string(k + 1))).string();
      make_folder(folder);
      write_model_pictures(file.organs[k], folder);
    }
  }
  for (const OrganModel& organ : file.organs) {
    const Eigen::VectorXd variances = mode_variances(organ.shape);
    console.out << "name       " << (organ.name.empty() ? "-" : organ.name) << "\nmodality   "
                << (organ.modality.empty() ? "-" : organ.modality) << "\ncases      " << organ.cases.size()
                << "\nvertices   " << organ.shape.vertex_count() << "\nerror      "
                << length_text(organ.surface_error_mm) << " (root mean square, cases left out)\nchecksum   "
                << file.checksum << "\n";
    const LearningCurve curve = learning_curve(organ);
    if (curve.fit) {
      const std::optional<int> needed = curve.fit->cases_within(kNeededShare);
      console.out << "limit      " << length_text(curve.fit->limit_mm) << " (error with many cases, extrapolated)\n"
                  << "needed     "
                  << (needed ? std::to_string(*needed) + " cases for an error within 10% of the limit" : "-") << "\n\n";
      std::vector<std::vector<std::string>> errors{{"training cases", "error mm", "fitted mm"}};
      for (const UnseenError& one : curve.points)
        errors.push_back(
            {std::to_string(one.cases), fixed_or_dash(one.error_mm, 3), fixed_or_dash(curve.fit->at(one.cases), 3)});
      print_table(console.out, errors, 1);
    }
    console.out << "\n";
    std::vector<std::vector<std::string>> table{{"mode", "deviation mm", "variance %", "together %"}};
    double sum = 0;
    for (Eigen::Index m = 0; m < variances.size(); ++m) {
      sum += variances[m];
      table.push_back({std::to_string(m + 1), fixed_or_dash(std::sqrt(variances[m] / organ.shape.vertex_count()), 3),
                       fixed_or_dash(100 * variances[m] / variances.sum(), 1),
                       fixed_or_dash(100 * sum / variances.sum(), 1)});
    }
    print_table(console.out, table, 1);
  }
}

}  // namespace

void add_model(const Subcommand& app, Action& action) {
  const Subcommand model =
      app.add_subcommand("model", "Trains and shows statistical models of organs (docs/models.md)");
  model.require_subcommand();
  const Subcommand sub =
      model.add_subcommand("train", "Trains a model of shape and intensity profiles from labelled cases");
  const auto options = std::make_shared<TrainOptions>();
  sub.add_option("TABLE", options->table,
                 "CSV table with the columns image, labels, label, mirror; several organs: lists separated by ';' "
                 "(docs/models.md)")
      .required();
  sub.add_option("OUT", options->out, "Model file").required().not_empty();
  const Option add =
      sub.add_option("--add", options->add, "Model to which the cases are added, without training on its cases again")
          .not_empty();
  sub.add_option("--name", options->training.name, "Name of the organ; of several: names separated by ';'");
  sub.add_option("--modality", options->training.modality, "Modality of the images, for example CT");
  sub.add_option("--vertices", options->training.settings.vertices,
                 "Approximate number of vertices of the template; 0: 1000, or more for a thin object")
      .within(0, 20000)
      .show_default()
      .excludes(add);
  sub.add_option("--modes", options->training.settings.modes, "Largest number of modes of the shape")
      .within(1, 1000)
      .show_default();
  sub.add_option(
         "--scale", options->scale,
         "Intensities: hounsfield (CT), percentiles (other images), or auto: hounsfield if all images contain air "
         "at -500 or below")
      .one_of({"auto", "hounsfield", "percentiles"})
      .show_default()
      .excludes(add);
  sub.add_flag("--curve", options->training.settings.measure_curve,
               "Measure the error for fewer cases too, from which show estimates how many cases are needed");
  sub.add_flag("--json", options->json,
               "Print the cases, their checksums and errors, and the checksum of the model as JSON");
  sub.add_option("--threads", options->threads, "CPU threads; 0: all cores").within(0, 1024).show_default();
  sub.callback([options, &action] { action = [options](const Console& console) { train(*options, console); }; });
  const Subcommand shown = model.add_subcommand("show", "Prints the modes of a model, its cases and its error");
  const auto path = std::make_shared<std::string>();
  shown.add_option("MODEL", *path, "Model file").required();
  const auto pictures = std::make_shared<std::string>();
  shown
      .add_option("--pictures", *pictures,
                  "Folder for pictures: the first modes at -2, 0 and +2 deviations, explained variance, and error "
                  "against the number of cases")
      .not_empty();
  shown.callback([path, pictures, &action] {
    action = [path, pictures](const Console& console) { show(*path, *pictures, console); };
  });
}

}  // namespace simplexseg
