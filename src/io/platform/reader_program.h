// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

namespace simplexseg {

/// Returns the path of the program simplexseg-reader: the value of the environment variable SIMPLEXSEG_READER if it is
/// set, otherwise the first that exists: beside the running program, beside the shared object that contains this
/// function (the Python module), in ../libexec/simplexseg beside the folder of the running program, and in the folder
/// of the installation. Throws Error when there is none.
std::filesystem::path reader_program();

}  // namespace simplexseg
