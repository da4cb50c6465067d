// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <memory>

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

/// One value a voxel, of which nothing is promised, with zeros before the first and after the last, as many as the
/// farthest neighbour is away: a kernel reads all six neighbours of every voxel without asking where it is.
template <class T>
class PaddedArray {
 public:
  PaddedArray() = default;
  explicit PaddedArray(const BoxGrid& grid)
      : pad_(grid.plane()),
        size_(grid.count() + 2 * std::size_t(pad_)),
        values_(std::make_unique_for_overwrite<T[]>(size_)) {
    std::fill_n(values_.get(), pad_, T{});
    std::fill_n(values_.get() + size_ - pad_, pad_, T{});
  }

  T* data() { return values_.get() + pad_; }
  const T* data() const { return values_.get() + pad_; }
  std::size_t bytes() const { return size_ * sizeof(T); }

 private:
  std::size_t pad_ = 0, size_ = 0;
  std::unique_ptr<T[]> values_;
};

}  // namespace simplexseg
