// SPDX-License-Identifier: Apache-2.0
// Classical methods that segment from the same marks, for the robot user (docs/clicks.md).
#pragma once
#include <memory>
#include <span>

#include "field/robot_user.h"
#include "field/run_jobs.h"
#include "image/volume.h"

namespace simplexseg {

struct PeerKind {
  const char* name;
  std::unique_ptr<RobotSubject> (*make)(const Volume& image, const RunJobs& run);
};

/// Peers by name. evidence: our evidence field. random-walker: Grady 2006, Random Walks for Image Segmentation.
/// growcut: Vezhnevets and Konouchine 2005, "GrowCut" - Interactive Multi-Label N-D Image Segmentation by Cellular
/// Automata. geodesic-contour and region-competition: the two level sets of ITK-SNAP (Yushkevich et al. 2006,
/// User-guided 3D active contour segmentation of anatomical structures).
std::span<const PeerKind> peers();

std::unique_ptr<RobotSubject> make_random_walker(const Volume& image, const RunJobs& run);
std::unique_ptr<RobotSubject> make_growcut(const Volume& image, const RunJobs& run);
std::unique_ptr<RobotSubject> make_geodesic_contour(const Volume& image, const RunJobs& run);
std::unique_ptr<RobotSubject> make_region_competition(const Volume& image, const RunJobs& run);

}  // namespace simplexseg
