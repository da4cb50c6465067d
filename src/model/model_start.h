// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>
#include <vector>

#include "field/marks.h"
#include "field/run_jobs.h"
#include "image/volume.h"
#include "model/model_fit.h"
#include "model/organ_model.h"
#include "model/pose_relations.h"

namespace simplexseg {

/// Seed of an organ that nobody has marked: the deepest voxel of the instance of its model at the mean place relative
/// to the volume, with its depth as radius. Nothing if the volume has another field of view (has_similar_extent()),
/// or the profiles of the instance differ from those of the organ, or it lies outside the volume. The volume must not
/// be empty.
std::optional<Mark> find_organ(const OrganModel& model, const Volume& volume, const RunJobs& run);

/// Organ of a model of several organs in an image.
struct FoundOrgan {
  int organ = 0;            ///< index in the model
  Eigen::Matrix3Xd points;  ///< vertices of its instance, or of its registered template, mm
};
/// Seeds of organs that nobody has marked, found from organs of the same model.
struct FoundSeed {
  int organ = 0;
  Mark seed;
  double cost = 0;  ///< ModelFit::cost
};

/// Finds the organs of a model in an image from those that are `found` already; without any, first the one that
/// find_organ() finds with the least cost. Each further organ is searched for at the place that the relations to those
/// found so far expect, in the order of certainty. An instance is discarded if its place is improbable, if its profiles
/// differ from those of the organ, or if it and an organ found before contain each other's deepest places: a neighbour
/// of equal shape and appearance is no substitute. `wanted`: indices of the organs to return; others are searched for
/// as well if they help. The volume must not be empty.
std::vector<FoundSeed> find_organs(const std::vector<OrganModel>& organs, const PoseRelations& relations,
                                   const Volume& volume, std::vector<FoundOrgan> found, const std::vector<int>& wanted,
                                   const RunJobs& run);

}  // namespace simplexseg
