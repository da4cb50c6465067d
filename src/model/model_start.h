// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "field/marks.h"
#include "field/run_jobs.h"
#include "image/volume.h"
#include "model/organ_model.h"

namespace simplexseg {

/// Seed of an organ that nobody has marked: the deepest voxel of the instance of its model at the mean place relative
/// to the volume, with its depth as radius. Nothing if the volume has another field of view (has_similar_extent()),
/// or the profiles of the instance differ from those of the organ, or it lies outside the volume. The volume must not
/// be empty.
std::optional<Mark> find_organ(const OrganModel& model, const Volume& volume, const RunJobs& run);

}  // namespace simplexseg
