// SPDX-License-Identifier: Apache-2.0
#include "app/load.h"

#include <ostream>

#include "app/progress.h"
#include "app/simulate.h"
#include "io/platform/files.h"

namespace simplexseg {

LoadedInput load_with_progress(const std::string& path, const LoadOptions& options, const Console& console) {
  const Progress progress(console, "reading");
  return load_scene(path, options);
}

EngineChoice engine_for(const std::string& backend, int threads, VolumeSampling sampling) {
  return as_failure([&] {
    if (backend == "cpu") return EngineChoice{make_cpu_engine(threads), {}, "", make_cpu_field_solver};
    EngineChoice choice = make_engine(backend == "cuda" ? Backend::Cuda : Backend::Auto, sampling);
    if (threads > 0 && choice.engine->backend() == std::string("cpu")) choice.engine = make_cpu_engine(threads);
    return choice;
  });
}

void print_warnings(const std::vector<std::string>& warnings, const Console& console) {
  for (const std::string& warning : warnings) console.err << "warning: " << one_line(warning, 1000) << "\n";
}

}  // namespace simplexseg
