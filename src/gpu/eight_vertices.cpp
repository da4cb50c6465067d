// SPDX-License-Identifier: Apache-2.0
// The kernels, compiled for AVX2, eight vertices at once. This unit alone is compiled so, and the program runs where
// there is no AVX2: nothing that is compiled here may be taken for the same function of another unit. So the whole of
// the project has another name here, and a test sees to it that the object shows nothing else (docs/adr/0025).
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
  // Its own copy: the compiler need not fear that stores change the view.
  const Kernel local = *static_cast<const Kernel*>(kernel);
  if constexpr (std::is_same_v<Kernel, MotionOfBlocks>)
    for (int block = first; block < first + count; ++block) local(block, EightLanes{});
  else if constexpr (requires { Kernel::kLanes; })
    for (int k = 0; k < count; ++k) local(Eight{first + kEight * k}, EightLanes{});
  else
    for (int k = 0; k < count; ++k) local(Eight{first + kEight * k});
}

template <class Kernel>
void put(EightVertices& all) {
  slot(all, std::type_identity<Kernel>{}) = &run<Kernel>;
}
/// Sanitizers take minutes to compile all sets of forces: of the set of all of them each force's code is there once.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kEverySet = false;
#else
constexpr bool kEverySet = true;
#endif
template <unsigned kMask>
void put_integration(EightVertices& all) {
  put<IntegrateKernel<kMask, false>>(all), put<IntegrateKernel<kMask, true>>(all);
  if constexpr (kMask != 0 && kEverySet) put_integration<((kMask - 1) & kBuiltForces)>(all);
}

EightVertices all_kernels() {
  EightVertices all;
  put<GeometryKernel>(all), put<SumRings>(all), put<MotionOfBlocks>(all);
  put_integration<kBuiltForces>(all);
  if constexpr ((kBuiltForces & bit(EvidenceForce::id)) != 0) put<AverageOverNeighbours>(all), put<EvidenceTarget>(all);
  [&]<class... T>(std::tuple<T...>*) {
    if constexpr ((kBuiltForces & bit(GradientForce::id)) != 0) (put<GradientSearch<LinearVoxels<T>, 1>>(all), ...);
    if constexpr ((kBuiltForces & bit(EvidenceForce::id)) != 0)
      (put<EvidenceStatistics<LinearVoxels<T>, 1>>(all), ...), (put<EvidenceSearch<LinearVoxels<T>, 1>>(all), ...);
  }(static_cast<EightVertices::Voxels*>(nullptr));
  return all;
}
#endif

}  // namespace

/// nullptr where the compiler was not told of AVX2.
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
