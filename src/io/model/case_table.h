// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace simplexseg {

/// Row of a table of labelled cases.
struct TableCase {
  std::string name;
  std::filesystem::path image, labels;
  std::string label;    ///< value or name; "": all voxels that are not 0
  bool mirror = false;  ///< mirrored left to right, for an organ of the other side
};
/// Reads a table of labelled cases: CSV in UTF-8 with the columns `image` and `labels`, and optionally `name`, `label`
/// and `mirror` (0 or 1). `reference` and `reference_label` are further names of `labels` and `label`, as in the table
/// of a cohort (docs/cohort.md). Relative paths are below the folder of the table. Throws Error with row and column.
std::vector<TableCase> read_case_table(const std::filesystem::path& path);

}  // namespace simplexseg
