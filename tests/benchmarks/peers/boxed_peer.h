// SPDX-License-Identifier: Apache-2.0
// What all peers share, so that it is the methods that are compared: box, marks, and what is taken as the object are
// those of the evidence field.
#pragma once
#include <vector>

#include "evidence/box_image.h"
#include "evidence/field_object.h"
#include "evidence/marked_voxels.h"
#include "evidence/robot_user.h"

namespace simplexseg {

/// What a method sees of an image: a box of it.
struct PeerInput {
  const BoxImage& image;                 ///< 1st percentile of the box 0, 99th 1
  Eigen::Vector3d spacing;               ///< in units of the least
  std::span<const Known> known;          ///< marks, and the sides of the box as outside
  std::span<const std::uint8_t> before;  ///< the object in the smaller box of the same marks, 0 or 1; all 0 at first
};

/// A method on a box that grows where the object comes near its sides, as that of the evidence field does. Its object
/// is what is connected to an inside mark, without holes but those of outside marks. Every update begins anew.
class BoxedPeer : public RobotSubject {
 public:
  BoxedPeer(const Volume& image, RunJobs run);
  /// Throws Error for marks that do not say what is inside.
  Mask segment(std::span<const Mark> marks) final;
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const final;

 protected:
  /// P(object) of each voxel of the box.
  virtual std::vector<float> solve(const PeerInput& input) = 0;
  const RunJobs& run() const { return run_; }

 private:
  Volume volume_;
  RunJobs run_;
  VoxelBox box_{};
  std::vector<Known> known_;
  FieldObject object_;
};

}  // namespace simplexseg
