// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <vector>

#include "core/vec3.h"

namespace simplexseg {

/// Voxels of a box, i fastest: how many, and how far neighbours lie apart in an array.
struct BoxGrid {
  std::array<int, 3> size{0, 0, 0};
  SIMPLEXSEG_HD int count() const { return size[0] * size[1] * size[2]; }
  SIMPLEXSEG_HD int row() const { return size[0]; }
  SIMPLEXSEG_HD int plane() const { return size[0] * size[1]; }
  SIMPLEXSEG_HD int stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? row() : plane(); }
};

/// One value a voxel, with zeros before the first and after the last, as many as the farthest neighbour is away: a
/// kernel reads all six neighbours of every voxel without asking where it is.
template <class T>
class PaddedArray {
 public:
  PaddedArray() = default;
  explicit PaddedArray(const BoxGrid& grid) : pad_(grid.plane()), values_(grid.count() + 2 * std::size_t(pad_)) {}

  T* data() { return values_.data() + pad_; }
  const T* data() const { return values_.data() + pad_; }
  std::size_t bytes() const { return values_.size() * sizeof(T); }

 private:
  int pad_ = 0;
  std::vector<T> values_;
};

}  // namespace simplexseg
