// SPDX-License-Identifier: Apache-2.0
#include "io/platform/reader_program.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <system_error>

#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr const char* kReaderName = "simplexseg-reader";

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

fs::path reader_program() {
  const std::string what = std::string("cannot start the program ") + kReaderName + ", which reads DICOM and MINC";
  if (const char* const named = std::getenv("SIMPLEXSEG_READER"); named && *named) {
    if (!is_program(named))
      throw Error(what, quoted(fs::path(named)) + " is not a program",
                  "correct the environment variable SIMPLEXSEG_READER");
    return named;
  }
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const fs::path& path :
       {folder / kReaderName, own_folder() / kReaderName, folder.parent_path() / "libexec/simplexseg" / kReaderName,
        fs::path(SIMPLEXSEG_LIBEXEC) / kReaderName}) {
    if (is_program(path)) return path;
  }
  throw Error(what, "it is missing", "install SimplexSeg again, or set the environment variable SIMPLEXSEG_READER");
}

}  // namespace simplexseg
