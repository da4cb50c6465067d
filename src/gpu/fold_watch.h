// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <span>
#include <vector>

#include "forces/step_view.h"

namespace simplexseg {

/// Tells meshes that steps have crumpled from those that were folded before, or that their forces fold.
class FoldWatch {
 public:
  bool knows(std::size_t meshes) const { return sound_.size() == meshes; }

  /// The share of folded vertices of each mesh now.
  void note(std::span<const MeshConstants> meshes, const MeshMotion* motion) {
    folded_.clear();
    for (std::size_t k = 0; k < meshes.size(); ++k)
      folded_.push_back(motion[k].folded / static_cast<float>(std::max(meshes[k].vertex_count, 1)));
  }
  /// The same for the pose that the scene begins with.
  void begin(std::span<const MeshConstants> meshes, const MeshMotion* motion) {
    note(meshes, motion);
    sound_ = folded_, undone_.assign(folded_.size(), 0);
  }

  /// Whether the pose is worth keeping, to go back to: a folded one takes the place of none that is not.
  bool keeps(std::size_t k) {
    if (k >= sound_.size()) return true;
    if (folded_[k] > kSound && sound_[k] <= kSound) return false;
    sound_[k] = folded_[k];
    return true;
  }
  /// Steps that grow until something bounds them leave a mesh that is folded all over, where it was not. Where smaller
  /// timesteps fold it too, it is the forces that do.
  bool crumpled(std::size_t k, float residual_mm, const MeshMotion& motion, float edge_mm) {
    constexpr int kTries = 6;
    if (folded_[k] <= kCrumpled || sound_[k] > kSound) return false;
    // What only smooths itself away has hardly a force left, and short edges.
    return (residual_mm > 0.25f * edge_mm || motion.mean_edge_mm > 2 * edge_mm) && undone_[k]++ < kTries;
  }
  /// The mesh was put back to the pose that is kept.
  void put_back(std::size_t k) {
    if (k < sound_.size() && k < folded_.size()) folded_[k] = std::min(folded_[k], sound_[k]);
  }

 private:
  /// Shares of folded vertices: at most so in a sound mesh, more than so in one that is no surface any more.
  static constexpr float kSound = 0.1f, kCrumpled = 0.25f;
  std::vector<float> folded_, sound_;  ///< of each mesh: at the end of the last interval, and in the pose that is kept
  std::vector<int> undone_;            ///< how often each mesh was undone because it folded
};

}  // namespace simplexseg
