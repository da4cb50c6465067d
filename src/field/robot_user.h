// SPDX-License-Identifier: Apache-2.0
// Robot user of an experiment: corrects a segmentation click by click, guided by a reference mask.
#pragma once
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "field/marks.h"
#include "image/mask.h"
#include "image/metrics.h"

namespace simplexseg {

/// Largest component (6-connected; the first of equal ones) of the missing or of the extra voxels of a segmentation,
/// and its voxel with the largest distance (mm) to all voxels outside the component.
struct WorstError {
  std::array<int, 3> voxel;
  double depth_mm;     ///< distance from that voxel to the nearest one outside the component
  std::size_t voxels;  ///< number of voxels of the component
  bool too_little;     ///< missing voxels; else extra ones
};
/// Worst error of a segmentation; nothing if it equals the reference. Throws Error if their grids differ.
std::optional<WorstError> worst_error(const Mask& truth, const Mask& now);

/// Voxel of the largest component of a mask with the largest distance to all others; nothing for an empty mask.
std::optional<WorstError> deepest_voxel(const Mask& mask);

/// Largest 6-connected component of a mask.
Mask largest_part(const Mask& mask);

/// Segmentation that a robot corrects, by a field or a mesh.
class RobotSubject {
 public:
  virtual ~RobotSubject() = default;
  /// Object mask for all marks so far; the first is the seed.
  virtual Mask segment(std::span<const Mark> marks) = 0;
  /// Radius of a new mark, mm, after segment().
  virtual double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const = 0;
};

/// Kind of the clicks of a robot, at the worst error.
enum class RobotClickKind {
  Marks,    ///< inside or outside mark in the middle of the error
  Points,   ///< boundary mark without a direction on the boundary of the reference beside the error
  Grabs,    ///< drag of the surface beside the error to the boundary of the reference: boundary mark with a direction
  Mixed,    ///< drag if the surface is near the middle of the error, else a mark
  Strokes,  ///< inside or outside stroke along the middle of the error
  Lassos,   ///< inside lasso around the object, or outside lasso around what is surplus, in a slice through the error
};

struct RobotSettings {
  int most_clicks = 20;            ///< after the seed
  double seed_scale = 1;           ///< radius of the seed, multiple of the correct radius
  double seed_offset = 0;          ///< offset of the centre of the seed along (1, 1, 1), multiple of the correct radius
  bool starts_with_box = false;    ///< a rectangle around the object instead of a seed
  bool starts_with_lasso = false;  ///< a closed contour around the object instead of a seed
  bool local = false;              ///< all corrections are local marks (Mark::local)
  RobotClickKind click_kind = RobotClickKind::Marks;
};

/// Extent of the changes by a click. All 0 for the seed.
struct ClickReach {
  double depth_mm = 0;     ///< distance from the click to the border of the error that it corrects (WorstError)
  double far_share = 0;    ///< changed voxels farther than kFarDepths depths from the click, per voxel of the reference
  double farthest_mm = 0;  ///< distance from the click to the farthest changed voxel
};
inline constexpr double kFarDepths = 3;
/// Compares the object masks before and after a click at `voxel` in an error of this depth. `truth_voxels`: number of
/// voxels of the reference. Throws Error if their grids differ.
ClickReach reach_of_click(const Mask& before, const Mask& after, const std::array<int, 3>& voxel, double depth_mm,
                          std::size_t truth_voxels);

/// State after a mark; the first is the seed.
struct RobotClick {
  Mark mark;
  Agreement agreement;
  double seconds;  ///< time of RobotSubject::segment()
  ClickReach reach;
};

/// Runs the protocol. The seed is a ball at the deepest voxel of the largest component of the reference, its radius is
/// that depth. Each click is then a mark at the deepest voxel of the worst error, or a boundary mark at the point of
/// the boundary of the reference that is nearest to that voxel. Ends early without an error. `after_click` receives the
/// number of the click and the object mask after it. Throws Error for an empty reference.
std::vector<RobotClick> run_robot(const Mask& truth, RobotSubject& subject, const RobotSettings& settings,
                                  const std::function<void(int, const Mask&)>& after_click);

}  // namespace simplexseg
