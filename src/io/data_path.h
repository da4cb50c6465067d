// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <string>

namespace simplexseg {

/// Where a path of a scene file is looked for: as it is, beside the scene, in the folders of SIMPLEXSEG_DATA
/// (colon-separated), in the templates of Debian's mricron-data. Throws Error listing these when it is nowhere.
std::filesystem::path find_data(const std::string& path, const std::filesystem::path& beside);

}  // namespace simplexseg
