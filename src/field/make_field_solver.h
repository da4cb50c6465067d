// SPDX-License-Identifier: Apache-2.0
// Factories of field solvers.
#pragma once
#include <functional>
#include <memory>

#include "field/run_jobs.h"

namespace simplexseg {

class FieldSolver;
class Volume;
struct EvidenceSettings;

/// Creates a solver for a volume, which must outlive it.
using MakeFieldSolver = std::function<std::unique_ptr<FieldSolver>(const Volume& volume, const RunJobs& run,
                                                                   const EvidenceSettings& settings)>;
/// Creates a solver on the CPU.
std::unique_ptr<FieldSolver> make_cpu_field_solver(const Volume& volume, const RunJobs& run,
                                                   const EvidenceSettings& settings);

}  // namespace simplexseg
