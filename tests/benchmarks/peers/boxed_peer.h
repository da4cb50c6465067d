// SPDX-License-Identifier: Apache-2.0
// Common part of all peers, so that only the methods differ: region of interest, constraints and extraction of the
// object are those of the evidence field.
#pragma once
#include <vector>

#include "field/box_image.h"
#include "field/field_object.h"
#include "field/marked_voxels.h"
#include "field/robot_user.h"

namespace simplexseg {

/// Input of a method: a box of the image with constraints.
struct PeerInput {
  const BoxImage& image;                 ///< intensities scaled from the 1st and 99th percentile of the box to 0 and 1
  Eigen::Vector3d spacing;               ///< voxel spacing relative to the smallest
  std::span<const Constraint> known;     ///< constraints of the marks and, as outside, of the sides of the box
  std::span<const std::uint8_t> before;  ///< object of the previous, smaller box, 0 or 1; initially all 0
};

/// Method on a box that grows where the object is near its sides, as in the evidence field. The object is the part
/// connected to an inside mark, with all holes filled except those of outside marks. Each update starts from scratch.
class BoxedPeer : public RobotSubject {
 public:
  BoxedPeer(const Volume& image, RunJobs run);
  /// Returns the object. Throws Error without an inside mark.
  Mask segment(std::span<const Mark> marks) final;
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const final;

 protected:
  /// Returns P(object) of each voxel of the box.
  virtual std::vector<float> solve(const PeerInput& input) = 0;
  const RunJobs& run() const { return run_; }

 private:
  Volume volume_;
  RunJobs run_;
  VoxelBox box_{};
  std::vector<Constraint> known_;
  FieldObject object_;
};

}  // namespace simplexseg
