// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <memory>
#include <ostream>
#include <thread>

#include "app/progress.h"
#include "cli/study.h"
#include "core/number_text.h"
#include "core/thread_pool.h"
#include "gpu/backend.h"
#include "io/platform/output_checks.h"
#include "study/field_stability_study.h"

namespace simplexseg {
namespace {

struct StudyFieldStabilityOptions {
  std::string folder, backend = "auto";
  int threads = 0;
};

FieldBackend field_backend(const StudyFieldStabilityOptions& options, const std::shared_ptr<ThreadPool>& pool) {
  const bool cuda = chooses_cuda(options.backend);
  FieldBackend backend;
  backend.threads = pool->threads();
  backend.run = [pool](int jobs, const std::function<void(int)>& job) { pool->run(jobs, job); };
  backend.description = cuda ? "CUDA, " + cuda_device()->name : "CPU, " + counted(pool->threads(), "thread");
  backend.solver = cuda ? MakeFieldSolver(make_cuda_field_solver) : make_cpu_field_solver;
  backend.walker = cuda ? SolveWalkerSystem(solve_walker_on_cuda) : solve_walker_on_cpu;
  return backend;
}

void run_field_stability_study(const StudyFieldStabilityOptions& options, const Console& console) {
  namespace fs = std::filesystem;
  require_writable_folder(options.folder);
  const int cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const auto pool = std::make_shared<ThreadPool>(options.threads > 0 ? options.threads : cores);
  const FieldBackend backend = field_backend(options, pool);
  make_folder(options.folder);
  const Interrupt interrupt;
  FieldStabilityStudy study;
  {
    Progress progress(console, "measuring stability of fields");
    study = study_field_stability(backend, [&](double share) {
      Interrupt::check();
      progress.set(share);
    });
  }
  const fs::path folder = options.folder;
  write_text(folder / "field-stability.csv", field_cases_csv(study));
  write_text(folder / "field-stability.md", field_stability_report(study));
  console.out << "wrote field-stability.md and field-stability.csv to " << options.folder << "\n";
  if (const int missed = study.missed(); missed > 0)
    throw Failure(counted(missed, "case differs", "cases differ") + " from the expected outcome; see " +
                  (folder / "field-stability.md").string());
}

}  // namespace

void add_study_field_stability(const Subcommand& studies, Action& action) {
  const Subcommand sub = studies.add_subcommand("field-stability",
                                                "Solves the evidence field for stiff and extreme images, grids, marks "
                                                "and systems, and compares the outcomes with "
                                                "the expected ones; exit status 1 if one differs");
  const auto options = std::make_shared<StudyFieldStabilityOptions>();
  sub.add_option("--out", options->folder, "Output folder for the tables; created if missing").required().not_empty();
  add_processor_options(sub, options->backend, options->threads);
  sub.callback([options, &action] {
    action = [options](const Console& console) { run_field_stability_study(*options, console); };
  });
}

}  // namespace simplexseg
