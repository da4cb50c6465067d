// SPDX-License-Identifier: Apache-2.0
#include "io/platform/worker_program.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <system_error>

#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

bool is_program(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored) && ::access(path.c_str(), X_OK) == 0;
}

/// Returns the folder of the shared object, or of the program, that contains this function.
fs::path own_folder() {
  Dl_info info{};
  std::error_code ignored;
  if (::dladdr(reinterpret_cast<void*>(&own_folder), &info) == 0 || !info.dli_fname) return {};
  return fs::weakly_canonical(info.dli_fname, ignored).parent_path();
}

}  // namespace

fs::path path_of_program(const WorkerProgram& program) {
  const std::string what = std::string("cannot start the program ") + program.name + ", " + program.purpose;
  if (const char* const named = std::getenv(program.variable); named && *named) {
    if (!is_program(named))
      throw Error(what, quoted(fs::path(named)) + " is not a program",
                  std::string("correct the environment variable ") + program.variable);
    return named;
  }
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const fs::path& path :
       {folder / program.name, own_folder() / program.name, folder.parent_path() / "libexec/simplexseg" / program.name,
        fs::path(SIMPLEXSEG_LIBEXEC) / program.name}) {
    if (is_program(path)) return path;
  }
  throw Error(what, "it is missing",
              std::string(program.remedy) + ", or set the environment variable " + program.variable);
}

}  // namespace simplexseg
