// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "forces/step_view.h"

namespace simplexseg {

/// Detects meshes that were folded by too large steps. Does not report meshes that were folded before, or that their
/// forces fold.
class FoldMonitor {
 public:
  bool initialised(std::size_t meshes) const { return saved_share_.size() == meshes; }

  /// Records the share of folded vertices of each mesh.
  void update(std::span<const MeshConstants> meshes, const MeshMotion* motion) {
    share_.clear();
    for (std::size_t k = 0; k < meshes.size(); ++k)
      share_.push_back(motion[k].folded / static_cast<float>(std::max(meshes[k].vertex_count, 1)));
  }
  /// Records the share of folded vertices of each mesh in the initial pose.
  void initialise(std::span<const MeshConstants> meshes, const MeshMotion* motion) {
    update(meshes, motion);
    saved_share_ = share_, undone_.assign(share_.size(), 0);
  }

  /// True if the current pose may replace the saved one: a folded pose never replaces one that is not folded.
  bool accept_pose(std::size_t k) {
    if (k >= saved_share_.size()) return true;
    if (share_[k] > kSound && saved_share_[k] <= kSound) return false;
    saved_share_[k] = share_[k];
    return true;
  }
  /// True if too large steps have folded a large share of mesh k, which was not folded before and has been undone fewer
  /// than six times. A mesh that still folds with smaller timesteps is folded by its forces.
  bool folded_by_steps(std::size_t k, float residual_mm, const MeshMotion& motion, float edge_mm) {
    constexpr int kMaxUndone = 6;
    if (share_[k] <= kFolded || saved_share_[k] > kSound) return false;
    // A mesh that shrinks by smoothing alone has small forces and short edges.
    return (residual_mm > 0.25f * edge_mm || motion.mean_edge_mm > 2 * edge_mm) && undone_[k]++ < kMaxUndone;
  }
  /// Updates the share of mesh k after its saved pose has been restored.
  void restore(std::size_t k) {
    if (k < saved_share_.size() && k < share_.size()) share_[k] = std::min(share_[k], saved_share_[k]);
  }

 private:
  static constexpr float kSound = 0.1f;     ///< largest folded share of a sound mesh
  static constexpr float kFolded = 0.25f;   ///< a mesh with a larger folded share counts as folded
  std::vector<float> share_, saved_share_;  ///< folded share of each mesh: in the current pose, and in the saved one
  std::vector<int> undone_;                 ///< number of times that each mesh was reset because it folded
};

}  // namespace simplexseg
