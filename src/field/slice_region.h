// SPDX-License-Identifier: Apache-2.0
// Connected voxels in a slice, from which strokes and contours are drawn.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "image/volume.h"

namespace simplexseg {

/// Voxels of a slice of a grid that are connected with a start voxel across faces.
class SliceRegion {
 public:
  /// `axis`: index axis perpendicular to the slice; `is_set`: whether the voxel at an offset of the grid belongs to a
  /// region, called once for each neighbour of it. The start belongs to it in any case.
  SliceRegion(const VolumeGeometry& grid, const std::array<int, 3>& start, int axis,
              const std::function<bool(std::size_t)>& is_set);

  double area_mm2() const { return area_mm2_; }
  std::size_t voxel_count() const { return voxels_.size(); }
  int axis() const { return 3 - a_ - b_; }
  /// Offsets of the voxels in the grid, the start first.
  std::vector<std::size_t> voxels() const;

  /// Corners of the voxels along the outer border, counter-clockwise, as fractional indices of the slice.
  std::vector<Eigen::Vector2d> outline() const;
  /// Longest path along the middle of the region, mm.
  std::vector<Eigen::Vector3d> middle();
  /// First and last voxel along both axes of the slice.
  std::array<std::array<int, 2>, 2> bounds() const;
  /// Place of fractional indices of the slice, mm.
  Eigen::Vector3d place(double a, double b) const;
  /// Axes of the slice, mm per voxel.
  Eigen::Matrix<double, 3, 2> axes() const;
  /// Unit normal of the slice.
  Eigen::Vector3d normal() const;
  /// Largest distance of a voxel to the nearest one outside the region, mm; 0 before middle().
  double deepest_mm() const { return deepest_; }

 private:
  int size_a() const { return grid_.size[a_]; }
  int size_b() const { return grid_.size[b_]; }
  std::size_t count() const { return static_cast<std::size_t>(size_a()) * size_b(); }
  bool contains(int a, int b) const { return a >= 0 && b >= 0 && a < size_a() && b < size_b(); }
  std::size_t offset(int a, int b) const { return static_cast<std::size_t>(b) * size_a() + a; }
  std::size_t start() const { return offset(fixed_[a_], fixed_[b_]); }
  std::array<int, 3> index(int a, int b) const;
  std::size_t voxel(int a, int b) const;
  Eigen::Vector3d place(std::size_t at) const;
  void find_depth();
  std::size_t farthest(std::size_t from);

  VolumeGeometry grid_;
  int a_, b_;  ///< index axes of the slice
  std::array<int, 3> fixed_;
  double area_mm2_ = 0;
  std::vector<std::size_t> voxels_;
  std::vector<float> depth_;
  float deepest_ = 0;
  std::vector<std::size_t> before_;  ///< predecessors on the paths of the last farthest()
};

}  // namespace simplexseg
