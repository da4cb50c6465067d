// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "evidence/coarse_image.h"
#include "evidence/evidence_settings.h"
#include "evidence/field_prior.h"
#include "evidence/marked_voxels.h"
#include "evidence/marks.h"
#include "evidence/random_walker.h"
#include "evidence/run_jobs.h"
#include "evidence/update_progress.h"
#include "image/volume.h"

namespace simplexseg {

/// Ball of a mark that was made since the field before; a boundary mark has two.
struct NewMarkBall {
  Eigen::Vector3d centre_mm;
  double radius_mm;
  bool inside;      ///< else outside
  double depth_mm;  ///< from its centre to the nearest voxel on the other side of the field before
};

/// Marks, constraints and previous field of an object.
struct Prompts {
  std::span<const Mark> marks;
  std::span<const Constraint> known;     ///< voxels of the box
  std::span<const std::uint8_t> before;  ///< field before the new dots, 1..255 for 0..1, 0: not known; or empty
  std::span<const NewMarkBall> fresh;    ///< empty where nothing is known of a field before
  double reach_mm, radius_mm;            ///< of the largest inside mark: the object's scale (seed_reach.h), the ball's
};

/// The prior of the evidence field on blocks of voxels: the wider, the larger the object is, so that an object of any
/// size is seen alike, noise is averaged, and a large object takes no longer than a small one. What the prior does not
/// see the image says when the field is solved, voxel by voxel.
class CoarsePrior {
 public:
  CoarsePrior(RunJobs run, const EvidenceSettings& settings);

  /// Sets the image of a box of cells whose first cell is `first`, for an object of this scale. `cells`: grid of all
  /// cells of the volume.
  void set_box(const BoxImage& image, const VolumeGeometry& cells, const std::array<int, 3>& first, double reach_mm);
  /// Learns from the marks what each block is. `progress`: receives the end of FieldPhase::CoarsePrior; or null.
  void learn(const Prompts& said, UpdateProgress* progress = nullptr);

  /// P(object), 0..255 for 0..1, of every voxel of the box, whose smoothed image this is; `edge`: a difference in it
  /// that is an edge.
  void interpolate(std::span<const float> image, float edge, std::span<std::uint8_t> voxels) const {
    coarse_.blocks.interpolate(prior_, {image, coarse_.smoothed, edge}, voxels, run_);
  }
  /// Marks as not 0 the voxels of the box's sides that may be the object's.
  void mark_open(std::span<const Constraint> known, std::span<std::uint8_t> open) const;

  /// What the networks saw, feature by feature (EvidenceField::mark_features).
  std::vector<std::vector<float>> mark_features(const Prompts& said) const;
  std::vector<std::vector<float>> update_features(const Prompts& said) const;
  const VoxelBlocks& blocks() const { return coarse_.blocks; }
  /// What was known of each block.
  std::span<const Constraint> known() const { return known_; }
  std::size_t bytes() const;

 private:
  std::vector<Constraint> known_blocks(const Prompts& said) const;
  std::vector<std::uint8_t> mean_before(std::span<const std::uint8_t> before) const;
  template <class Use>
  void with_input(const Prompts& said, Use&& use) const;
  template <class Features>
  std::vector<std::vector<float>> listed(const Features& features) const;
  void walk(const PriorInput& input);

  RunJobs run_;
  EvidenceSettings settings_;
  CoarseImage coarse_;
  std::vector<Constraint> known_;
  Looks looks_;
  std::vector<float> walk_;  ///< the random walker of the marks alone
  std::vector<std::uint8_t> prior_;
};

}  // namespace simplexseg
