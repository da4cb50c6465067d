// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <ostream>

#include "app/case_report.h"
#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "cli/commands.h"
#include "cli/run_scene.h"
#include "gpu/backend.h"
#include "io/platform/output_checks.h"
#include "io/scene/load_input.h"
#include "io/scene/measurement_export.h"
#include "session/measurement_csv.h"
#include "session/session.h"

namespace simplexseg {
namespace {

struct MeasureOptions {
  std::string scene;
  std::vector<std::string> outputs;
  bool patient = false;
};

void write_measurements(const MeasureOptions& options, const Console& console) {
  const std::filesystem::path folder = std::filesystem::path(options.scene).parent_path();
  const auto check = [&](const SceneFile& file) {
    OutputChecks checks(inputs_of(file, folder));
    checks.add_input(options.scene);
    for (const std::string& output : options.outputs) {
      require_measurement_name(output, file.scene);
      for (const std::filesystem::path& written : measurement_files(output)) checks.require_file(written);
    }
  };
  std::string table;
  std::vector<std::string> warnings, notes;
  {
    const Progress progress(console, "measuring");
    LoadedInput loaded = load_scene(options.scene, {.check = check});
    warnings = std::move(loaded.warnings);
    const std::string unit = unit_after(loaded.scene.volume_preprocessing.filters, loaded.intensity_unit);
    const CaseReportInput report{loaded.volume_path, options.patient ? loaded.patient : "", loaded.series, unit,
                                 loaded.low_is_bright};
    Session session(make_cpu_engine());
    session.open(std::move(loaded.scene), std::move(loaded.volume));  // completes the meshes
    if (options.outputs.empty()) table = measurement_csv(session.scene(), session.volume());
    as_failure([&] {
      for (const std::string& output : options.outputs) {
        if (is_case_report(output))
          write_case_report(output, session.scene(), session.volume(), report);
        else
          notes.push_back(save_measurements(output, session.scene(), session.volume(), unit));
      }
    });
  }
  print_warnings(warnings, console);
  for (const std::string& note : notes)
    if (!note.empty()) console.err << "note: " << note << "\n";
  console.out << table;
}

}  // namespace

void add_measure(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("measure",
                         "Writes the measurements of a scene as a CSV table, PDF or DICOM structured report: lengths, "
                         "angles and ellipses with their intensities, and for "
                         "each mesh its volume, its intensities, and long and short axis (RECIST 1.1)");
  const auto options = std::make_shared<MeasureOptions>();
  sub.add_option("SCENE", options->scene, "Scene file").required();
  sub.add_option(
         "OUT", options->outputs,
         "Output files: .csv: table; .pdf: report with pictures, prompts and checksums; .sr.dcm: DICOM structured "
         "report of a DICOM image, with the segmentation NAME.seg.dcm to which it refers. Default: the table to "
         "standard output")
      .not_empty();
  sub.add_flag("--patient", options->patient, "Print the patient's name, else the patient ID, in the PDF");
  sub.callback(
      [options, &action] { action = [options](const Console& console) { write_measurements(*options, console); }; });
}

}  // namespace simplexseg
