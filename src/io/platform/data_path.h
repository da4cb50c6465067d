// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// Returns the first existing file for a path from a scene file. It is searched as given, relative to `scene_folder`
/// (the scene's folder), in the folders of SIMPLEXSEG_DATA (colon-separated) and in the templates of Debian's
/// mricron-data. Throws Error with all searched paths when none exists.
std::filesystem::path find_data(const std::string& path, const std::filesystem::path& scene_folder);

}  // namespace simplexseg
