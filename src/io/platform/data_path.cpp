// SPDX-License-Identifier: Apache-2.0
#include "io/platform/data_path.h"

#include <cstdlib>
#include <sstream>
#include <vector>

#include "core/error.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

fs::path find_data(const std::string& path, const fs::path& scene_folder) {
  if (path.empty()) throw Error("cannot open a file", "its path is empty", "choose a file");
  std::vector<fs::path> places{fs::path(path)};
  if (fs::path(path).is_relative()) {
    places.push_back(scene_folder / path);
    if (const char* const folders = std::getenv("SIMPLEXSEG_DATA")) {
      std::istringstream list(folders);
      for (std::string folder; std::getline(list, folder, ':');) {
        if (!folder.empty()) places.push_back(fs::path(folder) / path);
      }
    }
    places.push_back(fs::path("/usr/share/mricron/templates") / path);
  }
  std::string searched;
  for (const fs::path& place : places) {
    std::error_code failure;
    if (fs::exists(place, failure)) return place;
    searched += (searched.empty() ? "" : ", ") + place.lexically_normal().string();
  }
  throw Error("cannot find " + quoted(fs::path(path)), "none of these files exists: " + one_line(searched, 1000),
              "correct the path or set SIMPLEXSEG_DATA to the data folder");
}

}  // namespace simplexseg
