// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

/// Bit-exact compact copy of a scene. Arrays that equal those of an adjacent snapshot are shared with it, and the
/// positions of the previous step are stored as differences from the pose. Immutable; cheap to copy.
class SceneSnapshot {
 public:
  /// `adjacent`: snapshot with which unchanged arrays are shared; null: none.
  explicit SceneSnapshot(Scene scene, const SceneSnapshot* adjacent = nullptr);

  template <class T>
  using Block = std::shared_ptr<const std::vector<T>>;
  /// Arrays of a mesh; no pointer is null.
  struct Arrays {
    Block<Eigen::Vector3f> positions;
    Block<std::array<int, 3>> neighbours;
    Block<std::uint8_t> previous;  ///< positions of the previous step, packed relative to `positions`
    Block<Vec4> shape;
    Block<float> profiles;
  };
  /// Restores a snapshot from without_arrays() and arrays() as read from a file; shares the given arrays. Throws Error
  /// for an invalid mesh, a position or shape reference that is not finite, or arrays of inconsistent sizes.
  SceneSnapshot(Scene without_arrays, std::vector<Arrays> arrays, const SceneSnapshot* adjacent);

  Scene restore() const;
  /// Scene whose meshes have no positions, neighbours, previous, shape and profiles.
  const Scene& without_arrays() const { return scene_; }
  /// Arrays of each mesh.
  const std::vector<Arrays>& arrays() const { return arrays_; }
  /// Size of the meshes, their arrays and fields that are not shared with the adjacent snapshot, bytes.
  std::size_t own_bytes() const { return own_bytes_; }

 private:
  const Arrays* arrays_of(ItemId mesh) const;
  void count_bytes(const SceneSnapshot* adjacent);

  Scene scene_;  ///< scene without the arrays
  std::vector<Arrays> arrays_;
  std::size_t own_bytes_ = 0;
};

}  // namespace simplexseg
