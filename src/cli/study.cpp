// SPDX-License-Identifier: Apache-2.0
#include "cli/study.h"

#include "core/error.h"
#include "gpu/backend.h"
#include "io/platform/atomic_file.h"

namespace simplexseg {

void add_study(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("study", "Measures the program and writes tables and plots");
  sub.require_subcommand();
  add_study_error_time(sub, action);
  add_study_field_error_time(sub, action);
  add_study_field_stability(sub, action);
  add_study_stability(sub, action);
}

void add_processor_options(const Subcommand& study, std::string& backend, int& threads) {
  study.add_option("--backend", backend, "Processor: cpu, cuda, or auto: CUDA if a device is available, else the CPU")
      .one_of({"auto", "cpu", "cuda"})
      .show_default();
  study.add_option("--threads", threads, "CPU threads; 0: all cores").within(0, 1024).show_default();
}

bool chooses_cuda(const std::string& backend) {
  const std::string unavailable = cuda_unavailable_reason();
  if (backend == "cuda" && !unavailable.empty()) throw Error("backend cuda", unavailable, "use --backend cpu");
  return backend == "cuda" || (backend == "auto" && unavailable.empty());
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  write_bytes(file, text);
  file.commit();
}

}  // namespace simplexseg
