// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

/// A scene as it was, to the bit, in little room: arrays that have not changed since an earlier snapshot are shared
/// with it, and the positions of the step before, which are near to those of the pose, are kept as their difference.
/// Immutable; cheap to copy.
class SceneSnapshot {
 public:
  /// `neighbour`: the snapshot with which to share what is the same; null: none.
  explicit SceneSnapshot(Scene scene, const SceneSnapshot* neighbour = nullptr);

  template <class T>
  using Block = std::shared_ptr<const std::vector<T>>;
  /// The arrays of a mesh; none is null.
  struct Arrays {
    Block<Eigen::Vector3f> positions;
    Block<std::array<int, 3>> neighbours;
    Block<std::uint8_t> previous;  ///< packed against `positions`
    Block<Vec4> shape;
    Block<float> profiles;
  };
  /// Of what without_arrays() and arrays() of another one gave, written and read again: shares what it is given.
  /// Throws Error when a mesh is not valid, has a value that is not finite, or arrays that do not go together.
  SceneSnapshot(Scene without_arrays, std::vector<Arrays> arrays, const SceneSnapshot* neighbour);

  Scene restore() const;
  /// The scene; its meshes have no positions, neighbours, previous, shape and profiles.
  const Scene& without_arrays() const { return scene_; }
  /// Of each mesh.
  const std::vector<Arrays>& arrays() const { return arrays_; }
  /// What it holds besides what it shares with the neighbour that it was made beside.
  std::size_t own_bytes() const { return own_bytes_; }

 private:
  const Arrays* arrays_of(ItemId mesh) const;
  void count_bytes(const SceneSnapshot* neighbour);

  Scene scene_;  ///< without the arrays
  std::vector<Arrays> arrays_;
  std::size_t own_bytes_ = 0;
};

}  // namespace simplexseg
