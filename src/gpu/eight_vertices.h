// SPDX-License-Identifier: Apache-2.0
// Kernels of a step that a CPU with AVX2 runs for eight vertices at once.
#pragma once
#include <cstdint>
#include <tuple>
#include <utility>

#include "gpu/forces_in_use.h"
#include "gpu/kernels.h"

namespace simplexseg {

/// Runs the kernel object `kernel` for `count` groups of eight vertices, starting with vertex `first`; a group must not
/// span two meshes. For BlockMotion, `first` and `count` refer to blocks.
using RunInEights = void (*)(const void* kernel, int first, int count);

/// Table of the kernels that are compiled for AVX2; a nullptr entry: kernel not compiled.
struct EightVertices {
  using Voxels =
      std::tuple<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t, float, double>;
  static constexpr int kVoxels = std::tuple_size_v<Voxels>;
  template <class T>
  static constexpr int index_of() {
    return []<class... U>(std::tuple<U...>*) {
      int index = 0;
      (void)((std::is_same_v<T, U> || (++index, false)) || ...);
      return index;
    }(static_cast<Voxels*>(nullptr));
  }
  RunInEights geometry = nullptr, rings = nullptr, motion = nullptr;
  RunInEights average = nullptr, evidence_target = nullptr;
  RunInEights gradient[kVoxels] = {}, statistics[kVoxels] = {}, evidence[kVoxels] = {};
  RunInEights integrate[kBuiltForces + 1][2] = {};
};
template <class All>
auto& slot(All& all, std::type_identity<GeometryKernel>) {
  return all.geometry;
}
template <class All>
auto& slot(All& all, std::type_identity<SumRings>) {
  return all.rings;
}
template <class All>
auto& slot(All& all, std::type_identity<BlockMotion>) {
  return all.motion;
}
template <class All, unsigned kMask, bool kCycles>
auto& slot(All& all, std::type_identity<IntegrateKernel<kMask, kCycles>>) {
  return all.integrate[kMask][kCycles];
}
template <class All>
auto& slot(All& all, std::type_identity<AverageOverNeighbours>) {
  return all.average;
}
template <class All>
auto& slot(All& all, std::type_identity<EvidenceTarget>) {
  return all.evidence_target;
}
template <class All, class T>
auto& slot(All& all, std::type_identity<GradientSearch<LinearVoxels<T>, 1>>) {
  return all.gradient[EightVertices::index_of<T>()];
}
template <class All, class T>
auto& slot(All& all, std::type_identity<EvidenceStatistics<LinearVoxels<T>, 1>>) {
  return all.statistics[EightVertices::index_of<T>()];
}
template <class All, class T>
auto& slot(All& all, std::type_identity<EvidenceSearch<LinearVoxels<T>, 1>>) {
  return all.evidence[EightVertices::index_of<T>()];
}
/// Kernel that has an entry in the table.
template <class Kernel>
concept RunsInEights = requires(EightVertices& all) {
  slot(all, std::type_identity<Kernel>{});
};

}  // namespace simplexseg
