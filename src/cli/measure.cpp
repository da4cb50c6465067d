// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <ostream>

#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "cli/commands.h"
#include "cli/run_scene.h"
#include "gpu/backend.h"
#include "io/platform/atomic_file.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "io/scene/load_input.h"
#include "session/measurement_csv.h"
#include "session/session.h"

namespace simplexseg {
namespace {

struct MeasureOptions {
  std::string scene, output;
};

void write_measurements(const MeasureOptions& options, const Console& console) {
  const std::filesystem::path folder = std::filesystem::path(options.scene).parent_path();
  const auto check = [&](const SceneFile& file) {
    if (options.output.empty()) return;
    OutputChecks checks(inputs_of(file, folder));
    checks.add_input(options.scene);
    checks.require_file(options.output);
  };
  std::string table;
  std::vector<std::string> warnings;
  {
    const Progress progress(console, "measuring");
    LoadedInput loaded = load_scene(options.scene, {.check = check});
    warnings = std::move(loaded.warnings);
    Session session(make_cpu_engine());
    session.open(std::move(loaded.scene), std::move(loaded.volume));  // completes the meshes
    table = measurement_csv(session.scene(), session.volume());
  }
  print_warnings(warnings, console);
  if (options.output.empty()) {
    console.out << table;
    return;
  }
  as_failure([&] {
    AtomicFile file(options.output);
    write_bytes(file, table);
    file.commit();
  });
}

}  // namespace

void add_measure(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "measure",
      "Writes the measurements of a scene as a CSV table: lengths, angles and ellipses with their intensities, and for "
      "each mesh its volume, its intensities, and long and short axis (RECIST 1.1)");
  const auto options = std::make_shared<MeasureOptions>();
  sub.add_option("SCENE", options->scene, "Scene file").required();
  sub.add_option("TABLE", options->output, "Output file (.csv); default: standard output").not_empty();
  sub.callback(
      [options, &action] { action = [options](const Console& console) { write_measurements(*options, console); }; });
}

}  // namespace simplexseg
