// SPDX-License-Identifier: Apache-2.0
#include "cli/study.h"

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

void write_text(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  write_bytes(file, text);
  file.commit();
}

}  // namespace simplexseg
