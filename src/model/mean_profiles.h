// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "field/run_jobs.h"
#include "image/volume.h"
#include "model/organ_model.h"

namespace simplexseg {

/// Vertex of a template from which each vertex of a mesh descends, for a mesh that has the connectivity of the
/// template, refined any number of times (Refined::parent). Nothing for a mesh of another connectivity.
std::optional<std::vector<int>> template_vertices(const SimplexMesh& of_template, const SimplexMesh& mesh);

/// Mean profiles of a model in intensities of a volume, from inside outwards: `2 * half + 1` samples per vertex, at
/// distances of `step_mm`, interpolated between those of the model. `place_mm`: place in the organ, around which
/// percentiles are determined, as in ModelFitter. The volume must not be empty. Throws Error for profiles that are
/// longer than those of the model.
std::vector<float> mean_profiles(const OrganModel& model, const Volume& volume, const Eigen::Vector3d& place_mm,
                                 int half, double step_mm, const RunJobs& run);

}  // namespace simplexseg
