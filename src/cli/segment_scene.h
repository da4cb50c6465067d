// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "field/run_jobs.h"
#include "io/scene/scene_io.h"

namespace simplexseg {

/// Options of `segment`. Positions are texts "X,Y,Z" in mm (LPS).
struct SegmentRequest {
  std::string image, series;
  int volume_number = 1;
  std::string scene;  ///< template scene; empty: none
  std::vector<std::string> seeds, names;
  std::vector<double> radii;                           ///< radii, mm: one for all seeds, or one per seed; empty: 10 mm
  std::string start_labels;                            ///< labels of the initial meshes, instead of seeds
  std::vector<std::string> inside, outside, boundary;  ///< points: "X,Y,Z" with one mesh, else "MESH=X,Y,Z"
  std::string reference;
  std::optional<double> reference_label;
  std::vector<std::string> models;  ///< model files: one for all meshes, or one per mesh
  /// Names of organs of the model to segment, if it has several; empty: all.
  std::vector<std::string> organs;
  /// Organ of each seed, for a model of several organs; the others are found from these.
  std::vector<std::string> seed_organs;
  std::string label_preset;  ///< name of a label preset, or path of a file; empty: none
};

/// Builds the scene of the options, with the image as its volume. Throws Error for invalid options.
SceneFile segment_scene(const SegmentRequest& request);

/// Whether some meshes of the options start where their models find their organs: they have no other start.
bool starts_from_models(const SegmentRequest& request);
/// Places the seeds of meshes where their models find their organs in the volume (find_organ(), find_organs()), and
/// returns warnings. Organs of a model of several that are not found are removed from the scene with a warning. Throws
/// Error for an organ that the options name, or the organ of a seed, if the model does not recognise it, and if no
/// organ is found.
std::vector<std::string> place_seeds_by_models(const SegmentRequest& request, Scene& scene, const Volume& volume,
                                               const RunJobs& run);

}  // namespace simplexseg
