// SPDX-License-Identifier: Apache-2.0
// Shared part of `run` and `segment`: runs a scene and writes labels, meshes, report and picture.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "io/scene/load_input.h"
#include "io/scene/log_io.h"

namespace simplexseg {

/// Options of a run: backend, number of steps and outputs.
struct RunOptions {
  std::string backend = "auto", sampling = "filtered";
  int threads = 0;      ///< threads of the CPU engine; 0: `max_threads`
  int max_threads = 0;  ///< threads for fields, and for an engine without an explicit number; 0: all cores
  std::optional<int> steps;
  bool until_rest = false;
  std::vector<std::string> settings;
  std::string labels, meshes, mesh_format = "ply", report, picture, save;
  int picture_size = 400;
};

inline constexpr const char* kLabelsHelp =
    "Output file for the labels (.nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .dcm: DICOM SEG) or contours (.rtstruct.dcm: "
    "DICOM RT structure set)";

/// Handles to the options for the number of steps, so that another option can exclude them.
struct StepOptions {
  Option steps, until_rest;
};
/// Adds all options except `--labels`, which is positional in some subcommands.
StepOptions add_run_options(const Subcommand& sub, RunOptions& options);

/// Scene of a run and its source.
struct RunInput {
  LoadedInput loaded;
  std::string scene;                             ///< path for the report; empty: the scene has no file
  std::vector<std::filesystem::path> read_from;  ///< input files other than the volume; outputs must not replace them
  std::optional<LogFile> log;                    ///< log that replaces the steps of the scene; none: no log
  double start = 0;                              ///< seconds_now() before the input was read
};
/// Runs a scene and writes the outputs. Throws Error for invalid options and outputs before the run starts, and Failure
/// if the run fails.
void run_scene(RunInput input, const RunOptions& options, const Console& console);

}  // namespace simplexseg
