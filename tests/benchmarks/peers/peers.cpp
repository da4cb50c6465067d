// SPDX-License-Identifier: Apache-2.0
#include "peers/peers.h"

#include "field/field_subject.h"

namespace simplexseg {
namespace {

constexpr PeerKind kPeers[] = {
    {"evidence",
     [](const Volume& image, const RunJobs& run) -> std::unique_ptr<RobotSubject> {
       return std::make_unique<FieldSubject<>>(image, run);
     }},
    {"random-walker", make_random_walker},
    {"growcut", make_growcut},
    {"geodesic-contour", make_geodesic_contour},
    {"region-competition", make_region_competition},
};

}  // namespace

std::span<const PeerKind> peers() { return kPeers; }

}  // namespace simplexseg
