// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "forces/step_view.h"

namespace simplexseg {

/// Detects meshes that too large timesteps have folded. Meshes that were folded before, or that are folded by their
/// forces at any timestep, are not reported.
class FoldMonitor {
 public:
  bool initialised(std::size_t meshes) const { return saved_share_.size() == meshes; }

  /// Records the share of folded vertices of each mesh in the current pose. `motion`: measurements, one per mesh.
  void update(std::span<const MeshConstants> meshes, const MeshMotion* motion) {
    share_.clear();
    for (std::size_t k = 0; k < meshes.size(); ++k)
      share_.push_back(motion[k].folded / static_cast<float>(std::max(meshes[k].vertex_count, 1)));
  }
  /// Records the share of folded vertices of each mesh in the initial pose, which is the saved one.
  void initialise(std::span<const MeshConstants> meshes, const MeshMotion* motion) {
    update(meshes, motion);
    saved_share_ = share_, undone_.assign(share_.size(), 0);
  }

  /// True if the current pose of mesh k may replace the saved one, whose share is then updated: a pose that is not
  /// sound (kSound) never replaces a sound one.
  bool accept_pose(std::size_t k) {
    if (k >= saved_share_.size()) return true;
    if (share_[k] > kSound && saved_share_[k] <= kSound) return false;
    saved_share_[k] = share_[k];
    return true;
  }
  /// True if too large timesteps have folded a large share of mesh k, whose saved pose is sound. `edge_mm`: mean edge
  /// length when the mesh was created or refined. True at most six times per mesh: a mesh that still folds with smaller
  /// timesteps is folded by its forces.
  bool folded_by_steps(std::size_t k, float residual_mm, const MeshMotion& motion, float edge_mm) {
    constexpr int kMaxUndone = 6;
    if (share_[k] <= kFolded || saved_share_[k] > kSound) return false;
    // A mesh that only smoothing shrinks has small forces and short edges; its folds are not caused by the timestep.
    return (residual_mm > 0.25f * edge_mm || motion.mean_edge_mm > 2 * edge_mm) && undone_[k]++ < kMaxUndone;
  }
  /// Updates the share of mesh k after its saved pose has been restored.
  void restore(std::size_t k) {
    if (k < saved_share_.size() && k < share_.size()) share_[k] = std::min(share_[k], saved_share_[k]);
  }

 private:
  static constexpr float kSound = 0.1f;     ///< largest share of folded vertices in a sound pose
  static constexpr float kFolded = 0.25f;   ///< a mesh with a larger folded share counts as folded
  std::vector<float> share_, saved_share_;  ///< share of folded vertices of each mesh, current and saved
  std::vector<int> undone_;                 ///< number of calls of folded_by_steps() that found each mesh folded
};

}  // namespace simplexseg
