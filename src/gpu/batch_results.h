// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <algorithm>
#include <optional>
#include <span>

#include "gpu/kernels.h"
#include "gpu/launcher.h"
#include "gpu/mesh_arrays.h"

namespace simplexseg {

/// Results of a batch of steps that the host reads: the first failure, and the measurements of each mesh (MeshMotion).
template <class Executor>
class BatchResults {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  BatchResults() { status_.resize(1), result_.resize(1), reset(); }
  /// Allocates the arrays for the results of these meshes.
  void load(const MeshArrays<Executor>& meshes) {
    blocks_ = (meshes.largest_mesh() + BlockMotion::kBlock - 1) / BlockMotion::kBlock;
    sums_.resize(meshes.size() * blocks_);
    motion_.resize(meshes.size());
    std::fill_n(motion_.data(), meshes.size(), MeshMotion{});
  }
  StepStatus* status() { return status_.data(); }

  /// Launches the kernels that measure the motion and write the results. The host may read the results after
  /// Executor::wait().
  void end_batch(Launcher<Executor>& launcher, const StepView& view) {
    launcher.run(BlockMotion{view, sums_.data(), blocks_}, static_cast<int>(sums_.size()));
    launcher.run(EndOfBatch{view, sums_.data(), blocks_, motion_.data(), result_.data()}, view.mesh_count);
  }

  struct Failure {
    int step;    ///< index of the failed step in the batch
    int vertex;  ///< index of the vertex among the vertices of all meshes
    ForceId force;
  };
  std::optional<Failure> failure() {
    const unsigned long long failure = result_.data()[0].failure;
    if (failure == ~0ull) return std::nullopt;
    return Failure{static_cast<int>(failure >> 40), static_cast<int>(failure >> 8 & 0xffffffffu),
                   static_cast<ForceId>(failure & 0xff)};
  }
  const MeshMotion* motion() { return motion_.data(); }

  /// Calls add(name, arrays...) for each group of arrays.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("motion", sums_);
  }

 private:
  void reset() {
    const StepStatus none;
    status_.upload(std::span(&none, 1));
  }

  int blocks_ = 0;  ///< number of blocks of BlockMotion::kBlock vertices in the largest mesh
  Array<MeshMotion> sums_;
  Array<StepStatus> status_;
  typename Executor::template HostVisible<StepStatus> result_;
  typename Executor::template HostVisible<MeshMotion> motion_;
};

}  // namespace simplexseg
