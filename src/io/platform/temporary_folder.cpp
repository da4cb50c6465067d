// SPDX-License-Identifier: Apache-2.0
#include "io/platform/temporary_folder.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>
#include <system_error>

#include "core/system_error.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::error_code error;
  const fs::path parent = fs::temp_directory_path(error);
  std::string name = ((error ? fs::path("/tmp") : parent) / "simplexseg-XXXXXX").string();
  if (!::mkdtemp(name.data()))
    throw Error("cannot create the temporary folder " + quoted(fs::path(name)), system_error_text(errno),
                "set TMPDIR to a writable folder");
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  fs::remove_all(path_, error);
}

}  // namespace simplexseg
