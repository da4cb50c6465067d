// SPDX-License-Identifier: Apache-2.0
// Changed keys as JSON: docs/manual.md, "Other keys".
#pragma once
#include <filesystem>
#include <string>

#include "gui/input/key_assignment.h"

namespace simplexseg {

/// Differences from the default keys.
std::string keys_json(const KeyAssignment& keys);
/// Reads keys_json(). `place`: origin of the text in messages. Throws Error for an unknown act, an unknown or refused
/// key, or a key of two acts.
KeyAssignment keys_of_json(const std::string& text, const std::string& place);
/// Reads a file of keys_json(). Throws Error also if it cannot be read.
KeyAssignment read_key_file(const std::filesystem::path& path);
/// Writes keys_json() to a file. Throws Error if that fails.
void write_key_file(const std::filesystem::path& path, const KeyAssignment& keys);

}  // namespace simplexseg
