// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace simplexseg {

/// Labels of one organ.
struct OrganLabels {
  std::filesystem::path labels;  ///< empty: the organ is not labelled
  std::string label;             ///< value or name; "": all voxels that are not 0
};
/// Organs of a case from texts that are lists, separated by ';', of label files and labels: as many of both, or one
/// file or one label for all. An empty entry of a list means that the organ is not labelled. `file`: path of a name in
/// the first list. Throws Error for lists of different lengths, and what `file` throws.
std::vector<OrganLabels> organ_labels(const std::string& files, const std::string& labels,
                                      const std::function<std::filesystem::path(const std::string&)>& file);
/// Texts of organ_labels().
std::string files_text(const std::vector<OrganLabels>& organs);
std::string labels_text(const std::vector<OrganLabels>& organs);

/// Entries of a list separated by ';', without spaces around them.
std::vector<std::string> list_entries(const std::string& text);

/// Row of a table of labelled cases.
struct TableCase {
  std::string name;
  std::filesystem::path image;
  std::vector<OrganLabels> organs;  ///< at least one
  bool mirror = false;              ///< mirrored left to right, for an organ of the other side
};
/// Reads a table of labelled cases: CSV in UTF-8 with the columns `image` and `labels`, and optionally `name`, `label`
/// and `mirror` (0 or 1). `reference` and `reference_label` are further names of `labels` and `label`, as in the table
/// of a cohort (docs/cohort.md). Several organs: organ_labels(). Relative paths are below the folder of the table.
/// Throws Error with row and column.
std::vector<TableCase> read_case_table(const std::filesystem::path& path);

}  // namespace simplexseg
