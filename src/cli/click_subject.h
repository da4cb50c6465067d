// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "field/robot_user.h"

namespace simplexseg {

/// Segmentation that the command `clicks` corrects.
class ClickSubject : public RobotSubject {
 public:
  /// Returns the object mask of the field; empty without a field.
  virtual Mask field_object() const = 0;
  /// Returns true if the field leaks.
  virtual bool leaks() const = 0;
  /// Returns the expected Dice of EvidenceField::Report; NaN without a field.
  virtual double expected_dice() const = 0;
  /// Returns the number of folded vertices of the mesh, see folded_vertices(); 0 without a mesh.
  virtual int folded() const = 0;
};

}  // namespace simplexseg
