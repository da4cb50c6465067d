// SPDX-License-Identifier: Apache-2.0
// A robot in the place of a user: it knows the truth, and says as little of it as a user would with every click.
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

/// The largest part (6-connected; of equals the one with the first voxel) of where `truth` and `now` differ, all too
/// much or all too little, and its voxel that is farthest (mm) from all others that are not of it.
struct WorstError {
  std::array<int, 3> voxel;
  double depth_mm;     ///< distance from that voxel to the nearest one that is not of the part
  std::size_t voxels;  ///< of the part
  bool too_little;     ///< of the truth and missing, rather than too much
};
/// Nothing where the masks are equal. Throws Error when their grids differ.
std::optional<WorstError> worst_error(const Mask& truth, const Mask& now);

/// The voxel of the largest part of the mask that is farthest from all others, and how far. Nothing for an empty mask.
std::optional<WorstError> deepest_voxel(const Mask& mask);

/// The largest 6-connected part of a mask.
Mask largest_part(const Mask& mask);

/// What a robot corrects: the field alone, say, or a mesh.
class RobotSubject {
 public:
  virtual ~RobotSubject() = default;
  /// The object by all marks so far: a seed, then further marks.
  virtual Mask segment(std::span<const Mark> marks) = 0;
  /// Radius for a new mark at a place, after a segment().
  virtual double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const = 0;
};

/// What a robot says with a click.
enum class RobotHand {
  Marks,   ///< inside or outside, in the middle of the largest error
  Points,  ///< where the surface passes: the truth's boundary beside it
  Grabs,   ///< the wrong surface beside it, dragged there: a boundary mark that knows the way out
  Mixed,   ///< a grab where the surface is near the click, else a mark
};

struct RobotSettings {
  int most_clicks = 20;    ///< besides the seed
  double seed_scale = 1;   ///< radius of the seed, in right radii
  double seed_offset = 0;  ///< the seed's centre lies so many right radii off the right one, along (1, 1, 1)
  RobotHand hand = RobotHand::Marks;
};

/// The state after one mark; the first is the seed.
struct RobotClick {
  Mark mark;
  Agreement agreement;
  double seconds;  ///< that the subject took
};

/// The protocol: the seed is a ball at the deepest voxel of the truth's largest part, with that depth as its radius;
/// then, one a click, a mark at the deepest voxel of the largest error, inside or outside as the truth says, or a
/// boundary mark (without a direction) halfway between the two voxels of the truth's boundary that are nearest to it.
/// Ends early where nothing is wrong. `after_click` is called after each with its number and the object now. Throws
/// Error for an empty truth.
std::vector<RobotClick> run_robot(const Mask& truth, RobotSubject& subject, const RobotSettings& settings,
                                  const std::function<void(int, const Mask&)>& after_click);

}  // namespace simplexseg
