// SPDX-License-Identifier: Apache-2.0
#include "io/data_path.h"

#include <cstdlib>
#include <sstream>
#include <vector>

#include "core/error.h"
#include "io/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

fs::path find_data(const std::string& path, const fs::path& beside) {
  if (path.empty()) throw Error("the path of a file", "it is empty", "name a file");
  std::vector<fs::path> places{fs::path(path)};
  if (fs::path(path).is_relative()) {
    places.push_back(beside / path);
    if (const char* const folders = std::getenv("SIMPLEXSEG_DATA")) {
      std::istringstream list(folders);
      for (std::string folder; std::getline(list, folder, ':');) {
        if (!folder.empty()) places.push_back(fs::path(folder) / path);
      }
    }
    places.push_back(fs::path("/usr/share/mricron/templates") / path);
  }
  std::string looked;
  for (const fs::path& place : places) {
    std::error_code failure;
    if (fs::exists(place, failure)) return place;
    looked += (looked.empty() ? "" : ", ") + place.lexically_normal().string();
  }
  throw Error("cannot find " + quoted(fs::path(path)), "it is none of " + one_line(looked, 1000),
              "correct the path, or name the folder of the data in SIMPLEXSEG_DATA");
}

}  // namespace simplexseg
