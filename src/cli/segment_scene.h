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
  std::string label_preset;         ///< name of a label preset, or path of a file; empty: none
};

/// Builds the scene of the options, with the image as its volume. Throws Error for invalid options.
SceneFile segment_scene(const SegmentRequest& request);

/// Whether the meshes of the options start where their models find their organs: there is no other start.
bool starts_from_models(const SegmentRequest& request);
/// Places the seeds of meshes where their models find their organs in the volume (find_organ()). Throws Error for a
/// model that does not recognise its organ.
void place_seeds_by_models(Scene& scene, const Volume& volume, const RunJobs& run);

}  // namespace simplexseg
