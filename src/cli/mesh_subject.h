// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <string>

#include "cli/click_subject.h"
#include "image/volume.h"

namespace simplexseg {

struct EvidenceSettings;

/// Mesh that the robot corrects through a session, like a user. The mesh has the parameters of a new mesh, starts from
/// the seed of the robot, gets one point per further mark, and runs until it settles, at most 3000 steps per mark.
class MeshSubject : public ClickSubject {
 public:
  /// `evidence`: false disables the field, so that only internal forces and points act. `settings`: assignments of
  /// `run --set`, without those of a mesh; `fields`: settings of the field; `backend`, `threads`: see engine_for().
  /// Throws Error for an invalid setting.
  MeshSubject(Volume volume, bool evidence, std::span<const std::string> settings, const EvidenceSettings& fields,
              std::string backend, int threads);
  ~MeshSubject() override;
  /// Starts a new mesh if there are fewer marks than in the previous call.
  Mask segment(std::span<const Mark> marks) override;
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override;
  Mask field_object() const override;
  bool leaks() const override;
  double expected_dice() const override;
  int folded() const override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace simplexseg
