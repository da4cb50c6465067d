// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "field/evidence_field.h"
#include "field/robot_user.h"

namespace simplexseg {

/// Evidence field that the robot user corrects. `Subject`: RobotSubject or a class derived from it.
template <class Subject = RobotSubject>
class FieldSubject : public Subject {
 public:
  FieldSubject(const Volume& image, const RunJobs& run, const EvidenceSettings& settings = {},
               const MakeFieldSolver& make = make_cpu_field_solver)
      : field_(image, run, settings, make) {}
  Mask segment(std::span<const Mark> marks) override {
    field_.update(marks);
    return field_.object();
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return field_.brush_mm(kind, mm); }
  const EvidenceField& field() const { return field_; }

 protected:
  EvidenceField& changeable_field() { return field_; }

 private:
  EvidenceField field_;
};

}  // namespace simplexseg
