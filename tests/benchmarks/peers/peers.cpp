// SPDX-License-Identifier: Apache-2.0
#include "peers/peers.h"

#include "field/evidence_field.h"

namespace simplexseg {
namespace {

class FieldPeer : public RobotSubject {
 public:
  FieldPeer(const Volume& image, const RunJobs& run) : field_(image, run) {}
  Mask segment(std::span<const Mark> marks) override {
    field_.update(marks);
    return field_.object();
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return field_.brush_mm(kind, mm); }

 private:
  EvidenceField field_;
};

constexpr PeerKind kPeers[] = {
    {"evidence",
     [](const Volume& image, const RunJobs& run) -> std::unique_ptr<RobotSubject> {
       return std::make_unique<FieldPeer>(image, run);
     }},
    {"random-walker", make_random_walker},
    {"growcut", make_growcut},
    {"geodesic-contour", make_geodesic_contour},
    {"region-competition", make_region_competition},
};

}  // namespace

std::span<const PeerKind> peers() { return kPeers; }

}  // namespace simplexseg
