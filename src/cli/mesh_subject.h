// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <memory>
#include <span>
#include <string>

#include "cli/click_subject.h"
#include "image/volume.h"

namespace simplexseg {

struct EvidenceSettings;

/// What a robot corrects through the program as a user does: a mesh with the default parameters of a new one, that
/// starts as the robot's seed and gets a point for each further mark, and moves until it rests.
class MeshSubject : public ClickSubject {
 public:
  /// `evidence`: false leaves the mesh to its internal forces and its points. `settings`: as of `run --set`, without
  /// meshes; `fields`: how the mesh's field is made; `backend`: as of engine_for(). Throws Error for a setting that is
  /// none.
  MeshSubject(Volume volume, bool evidence, std::span<const std::string> settings, const EvidenceSettings& fields,
              std::string backend, int threads);
  ~MeshSubject() override;
  /// Fewer marks than the last time begin anew.
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
