// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// Returns the first existing location of a `path` from a scene file. A relative path is searched in the current
/// folder, in `scene_folder` (the folder of the scene file), in the folders of SIMPLEXSEG_DATA (colon-separated) and in
/// the templates of Debian's mricron-data. Throws Error when `path` is empty, and with all searched locations when none
/// exists.
std::filesystem::path find_data(const std::string& path, const std::filesystem::path& scene_folder);

}  // namespace simplexseg
