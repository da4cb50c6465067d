// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <ostream>

#include "cli/progress.h"
#include "cli/study.h"
#include "gpu/backend.h"
#include "io/files.h"
#include "io/plot_io.h"
#include "study/stability_study.h"

namespace simplexseg {
namespace {

struct Options {
  std::string folder, backend = "auto";
  int threads = 0;
};

void study(const Options& options, const Console& console) {
  namespace fs = std::filesystem;
  make_result_folder(options.folder);
  const bool cuda = options.backend == "cuda" || (options.backend == "auto" && why_no_cuda().empty());
  const EngineFactory make = [&] { return cuda ? make_cuda_engine() : make_cpu_engine(options.threads); };
  const Interrupt interrupt;
  StabilityStudy result;
  {
    Progress progress(console, "studying stability");
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
    throw Failure(std::to_string(missed) + " cases or limits are not as stated; see " +
                  (folder / "stability.md").string());
}

}  // namespace

void add_study_stability(const Subcommand& studies, Action& action) {
  const Subcommand sub = studies.add_subcommand(
      "stability",
      "Stiff and extreme cases with every solver against the outcomes that are stated for them, and the largest stable "
      "timestep of each force against its bound; exit status 1 when one is not as stated");
  const auto options = std::make_shared<Options>();
  sub.add_option("--out", options->folder, "Folder for tables and plots; made where it is not").required();
  sub.add_option("--backend", options->backend, "auto: CUDA where there is a device, else the CPU")
      .one_of({"auto", "cpu", "cuda"})
      .show_default();
  sub.add_option("--threads", options->threads, "CPU threads; 0: as many as the machine has")
      .within(0, 1024)
      .show_default();
  sub.callback([options, &action] { action = [options](const Console& console) { study(*options, console); }; });
}

}  // namespace simplexseg
