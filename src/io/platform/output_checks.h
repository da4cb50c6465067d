// SPDX-License-Identifier: Apache-2.0
// Checks of output files and folders before the work whose results they receive.
#pragma once
#include <filesystem>
#include <vector>

namespace simplexseg {

/// Throws Error if a file cannot be created or replaced at `path`: the folder is missing or not writable, the name is
/// too long, or `path` is a folder, a device or a pipe. Leaves no file.
void require_writable_output(const std::filesystem::path& path);
/// Throws Error if no file can be created in `folder`, or if the folder is missing and cannot be created. Leaves no
/// file and no folder.
void require_writable_folder(const std::filesystem::path& folder);
/// Creates a folder and its parents unless they exist. Throws Error if a folder cannot be created.
void make_folder(const std::filesystem::path& folder);

/// Outputs of one command. Each output is checked alone, against the inputs, and against the other outputs.
class OutputChecks {
 public:
  /// `inputs`: files and folders that the command reads; empty and missing paths are ignored.
  explicit OutputChecks(std::vector<std::filesystem::path> inputs) : inputs_(std::move(inputs)) {}
  void add_input(std::filesystem::path input) { inputs_.push_back(std::move(input)); }
  /// Throws the errors of require_writable_output(), and Error if the file is an input, belongs to one (DICOM image in
  /// an input folder, voxels of a detached header), or was named before.
  void require_file(const std::filesystem::path& output);
  /// Throws the errors of require_writable_folder(), and Error if the folder was named before.
  void require_folder(const std::filesystem::path& output);

 private:
  void require_unused(const std::filesystem::path& output);

  std::vector<std::filesystem::path> inputs_, outputs_;
};

}  // namespace simplexseg
