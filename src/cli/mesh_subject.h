// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>

#include "evidence/robot_user.h"
#include "image/volume.h"

namespace simplexseg {

/// What a robot corrects through the program as a user does: a mesh with the default parameters of a new one, that
/// starts as the robot's seed and gets a point for each further mark, and moves until it rests.
class MeshSubject {
 public:
  /// `evidence`: false leaves the mesh to its internal forces and its points.
  MeshSubject(Volume volume, bool evidence, int threads);
  ~MeshSubject();
  RobotSubject subject();
  /// Whether the mesh's field says that it leaks.
  bool leaks() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simplexseg
