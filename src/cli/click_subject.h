// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "evidence/robot_user.h"

namespace simplexseg {

/// What the command `clicks` has corrected.
class ClickSubject : public RobotSubject {
 public:
  /// What the field says is the object; empty without a field.
  virtual Mask field_object() const = 0;
  /// Whether the field says that it leaks.
  virtual bool leaks() const = 0;
  /// EvidenceField::Report; NaN without a field.
  virtual double expected_dice() const = 0;
  /// Vertices of the mesh at a fold, folded_vertices(); none without a mesh.
  virtual int folded() const = 0;
};

}  // namespace simplexseg
