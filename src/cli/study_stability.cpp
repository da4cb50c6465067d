// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <ostream>

#include "app/progress.h"
#include "cli/study.h"
#include "core/number_text.h"
#include "gpu/backend.h"
#include "io/picture/plot_io.h"
#include "io/platform/output_checks.h"
#include "study/stability_study.h"

namespace simplexseg {
namespace {

struct StudyStabilityOptions {
  std::string folder, backend = "auto";
  int threads = 0;
};

void run_stability_study(const StudyStabilityOptions& options, const Console& console) {
  namespace fs = std::filesystem;
  require_writable_folder(options.folder);
  make_folder(options.folder);
  const bool cuda = options.backend == "cuda" || (options.backend == "auto" && cuda_unavailable_reason().empty());
  const EngineFactory make = [&] { return cuda ? make_cuda_engine() : make_cpu_engine(options.threads); };
  const Interrupt interrupt;
  StabilityStudy result;
  {
    Progress progress(console, "measuring stability");
    result = study_stability(make, [&](double share) {
      Interrupt::check();
      progress.set(share);
    });
  }
  const fs::path folder = options.folder;
  write_text(folder / "stability.csv", cases_csv(result));
  write_text(folder / "stability_limits.csv", limits_csv(result));
  write_text(folder / "stability.md", stability_report(result));
  for (const char* name : {"stability_limits.svg", "stability_limits.png"})
    write_plot(folder / name, limits_plot(result), 900, 600);
  console.out << "wrote stability.md, stability.csv, stability_limits.csv, .svg and .png to " << options.folder << "\n";
  if (const int missed = result.missed(); missed > 0)
    throw Failure(counted(missed, "case or limit differs", "cases or limits differ") +
                  " from the expected outcome; see " + (folder / "stability.md").string());
}

}  // namespace

void add_study_stability(const Subcommand& studies, Action& action) {
  const Subcommand sub = studies.add_subcommand("stability",
                                                "Runs stiff and extreme cases with every solver, measures the largest "
                                                "stable timestep of each force, and compares "
                                                "both with the expected outcomes; exit status 1 if one differs");
  const auto options = std::make_shared<StudyStabilityOptions>();
  sub.add_option("--out", options->folder, "Output folder for tables and plots; created if missing")
      .required()
      .not_empty();
  add_processor_options(sub, options->backend, options->threads);
  sub.callback(
      [options, &action] { action = [options](const Console& console) { run_stability_study(*options, console); }; });
}

}  // namespace simplexseg
