// SPDX-License-Identifier: Apache-2.0
// Shared part of `run` and `segment`: runs a scene and writes labels, meshes, report and picture.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/commands.h"
#include "io/platform/output_checks.h"
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
  std::string labels, grid, fractions, meshes, mesh_format = "ply", report, picture, save;
  int picture_size = 400;
};

inline constexpr const char* kLabelsHelp =
    "Output file for the labels (.nii, .nii.gz, .nrrd, .seg.nrrd, .mha, .dcm: DICOM SEG, .labelmap.dcm: DICOM label "
    "map SEG) or contours (.rtstruct.dcm: DICOM RT structure set)";

/// Handles to the options for the number of steps, so that another option can exclude them.
struct StepOptions {
  Option steps, until_rest;
};
/// Adds all options except `--labels`, which is positional in some subcommands.
StepOptions add_run_options(const Subcommand& sub, RunOptions& options);

/// Scene of a run and its source.
struct RunInput {
  LoadedInput loaded;
  std::string scene;                ///< path for the report; empty: the scene has no file
  std::optional<LogFile> log;       ///< log that replaces the steps of the scene; none: no log
  double start = 0;                 ///< seconds_now() before the input was read
  std::vector<Command> commands{};  ///< applied before the first step
};
/// Files that the scene refers to; missing files are omitted. `folder`: folder of the scene file.
std::vector<std::filesystem::path> inputs_of(const SceneFile& file, const std::filesystem::path& folder);
/// Throws Error for invalid options, and for outputs whose names are not supported or that cannot be written. Needs no
/// scene, so that nothing is read before. `checks`: inputs, and outputs of other scenes.
void check_outputs(const RunOptions& options, OutputChecks& checks);
/// Throws the errors of check_outputs(), and Error for outputs that do not fit the scene, for example DICOM files
/// without a DICOM image. Called by load_scene() before the volume is read. `folder`: folder of the scene file;
/// `read_from`: input
/// files other than those of the scene; outputs must not replace them.
void check_outputs(const RunOptions& options, const SceneFile& file, const std::filesystem::path& folder,
                   const std::vector<std::filesystem::path>& read_from);
/// Runs a scene whose outputs were checked and writes the outputs. Throws Failure if the run fails.
void run_scene(RunInput input, const RunOptions& options, const Console& console);

}  // namespace simplexseg
