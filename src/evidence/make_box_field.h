// SPDX-License-Identifier: Apache-2.0
// Where the voxels of evidence fields are worked on, for those who hand that on.
#pragma once
#include <functional>
#include <memory>

#include "evidence/run_jobs.h"

namespace simplexseg {

class BoxField;
class Volume;
struct EvidenceSettings;

/// Makes one for a volume.
using MakeBoxField = std::function<std::unique_ptr<BoxField>(const Volume& volume, const RunJobs& run,
                                                             const EvidenceSettings& settings)>;
/// On the CPU.
std::unique_ptr<BoxField> make_cpu_box_field(const Volume& volume, const RunJobs& run,
                                             const EvidenceSettings& settings);

}  // namespace simplexseg
