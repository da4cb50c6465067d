// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>

namespace simplexseg {

/// Memory of the solver of a field on the CPU, bytes. A device needs about as much of its own memory.
struct FieldMemory {
  std::size_t held;     ///< between updates
  std::size_t solving;  ///< in addition, while the field is solved
};
/// Estimate for a field on this number of cells. Source: docs/results/clinical-size.md, bench_field.
constexpr FieldMemory expected_field_memory(std::size_t cells) { return {19 * cells, 83 * cells}; }

}  // namespace simplexseg
