// SPDX-License-Identifier: Apache-2.0
// What `run` and `segment` have in common: a scene is run, and labels, meshes, report and picture are written.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "io/load_input.h"
#include "io/log_io.h"

namespace simplexseg {

/// How far a scene is run, by what, and what is written of it.
struct RunOptions {
  std::string backend = "auto", sampling = "filtered";
  int threads = 0;       ///< of the CPU engine; 0: as many as it may have
  int most_threads = 0;  ///< of the engine that is not told how many, and for fields; 0: as many as the machine has
  std::optional<int> steps;
  bool until_rest = false;
  std::vector<std::string> settings;
  std::string labels, meshes, mesh_format = "ply", report, picture, save;
  int picture_size = 400;
};

inline constexpr const char* kLabelsHelp =
    "Write the voxels inside the meshes here (.nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .dcm: DICOM SEG), or their "
    "contours (.rtstruct.dcm)";

/// The two that say how far: another option may exclude them.
struct HowFar {
  Option steps, until_rest;
};
/// All of them but `--labels`, whose place differs.
HowFar add_run_options(const Subcommand& sub, RunOptions& options);

/// What is run, and where it is from.
struct RunInput {
  LoadedInput loaded;
  std::string scene;                             ///< as the report names it; empty: it is no file
  std::vector<std::filesystem::path> read_from;  ///< files besides the volume that no output may replace
  std::optional<LogFile> log;                    ///< that is repeated instead of the scene's steps
  double start = 0;                              ///< seconds_now() before anything was read
};
/// Throws Error for what cannot be had or written, before any time is spent, and Failure for what fails then.
void run_scene(RunInput input, const RunOptions& options, const Console& console);

}  // namespace simplexseg
