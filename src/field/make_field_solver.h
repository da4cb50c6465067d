// SPDX-License-Identifier: Apache-2.0
// Where the voxels of evidence fields are worked on, for those who hand that on.
#pragma once
#include <functional>
#include <memory>

#include "field/run_jobs.h"

namespace simplexseg {

class FieldSolver;
class Volume;
struct EvidenceSettings;

/// Makes one for a volume.
using MakeFieldSolver = std::function<std::unique_ptr<FieldSolver>(const Volume& volume, const RunJobs& run,
                                                                   const EvidenceSettings& settings)>;
/// On the CPU.
std::unique_ptr<FieldSolver> make_cpu_field_solver(const Volume& volume, const RunJobs& run,
                                                   const EvidenceSettings& settings);

}  // namespace simplexseg
