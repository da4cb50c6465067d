// SPDX-License-Identifier: Apache-2.0
// Kernels for eight vertices at once. Only this translation unit is compiled with AVX2, and the program also runs
// without AVX2, so the linker must not merge functions of this unit with those of others. Therefore the namespace of
// the project is renamed here; a test checks that the object file exports no symbols of other namespaces
// (docs/adr/0025-eight-vertices-at-once.md).
#define simplexseg simplexseg_avx2
#ifdef __AVX2__
#include "forces/eight_voxels.h"
#endif
#include "gpu/eight_vertices.h"

namespace simplexseg {
namespace {

#ifdef __AVX2__
template <class Kernel>
void run(const void* kernel, int first, int count) {
  // Local copy, which stores cannot alias.
  const Kernel local = *static_cast<const Kernel*>(kernel);
  if constexpr (std::is_same_v<Kernel, BlockMotion>)
    for (int block = first; block < first + count; ++block) local(block, EightLanes{});
  else if constexpr (requires { Kernel::kLanes; })
    for (int k = 0; k < count; ++k) local(Eight{first + kEight * k}, EightLanes{});
  else
    for (int k = 0; k < count; ++k) local(Eight{first + kEight * k});
}

template <class Kernel>
void register_kernel(EightVertices& all) {
  slot(all, std::type_identity<Kernel>{}) = &run<Kernel>;
}
template <unsigned kMask>
void register_integration(EightVertices& all) {
  register_kernel<IntegrateKernel<kMask, false>>(all), register_kernel<IntegrateKernel<kMask, true>>(all);
  if constexpr (kEverySet && kMask != 0) register_integration<((kMask - 1) & kBuiltForces)>(all);
}

EightVertices all_kernels() {
  EightVertices all;
  register_kernel<GeometryKernel>(all), register_kernel<SumRings>(all), register_kernel<BlockMotion>(all);
  register_integration<kBuiltForces>(all);
  if constexpr ((kBuiltForces & bit(EvidenceForce::id)) != 0)
    register_kernel<AverageOverNeighbours>(all), register_kernel<EvidenceTarget>(all);
  [&]<class... T>(std::tuple<T...>*) {
    if constexpr ((kBuiltForces & bit(GradientForce::id)) != 0)
      (register_kernel<GradientSearch<LinearVoxels<T>, 1>>(all), ...);
    if constexpr ((kBuiltForces & bit(EvidenceForce::id)) != 0)
      (register_kernel<EvidenceStatistics<LinearVoxels<T>, 1>>(all), ...),
          (register_kernel<EvidenceSearch<LinearVoxels<T>, 1>>(all), ...);
  }(static_cast<EightVertices::Voxels*>(nullptr));
  return all;
}
#endif

}  // namespace

/// Table of the kernels, an EightVertices; nullptr if this unit was compiled without AVX2.
const void* eight_vertices();
const void* eight_vertices() {
#ifdef __AVX2__
  static const EightVertices all = all_kernels();
  return &all;
#else
  return nullptr;
#endif
}

}  // namespace simplexseg
