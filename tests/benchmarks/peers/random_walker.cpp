// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/cpu_executor.h"
#include "field/parallel/walker.h"

#include <algorithm>
#include <cmath>

#include "peers/boxed_peer.h"
#include "peers/peers.h"

namespace simplexseg {
namespace {

// Grady 2006: beta = 90 for all images; squared differences are divided by the largest one.
constexpr float kBeta = 90;
constexpr float kLeastWeight = 1e-5f;  // keeps all voxels connected
constexpr double kTolerance = 0.005;   // tolerance of P
constexpr int kMostIterations = 200;

/// Random walker with marks only, without a prior.
class RandomWalkerPeer : public BoxedPeer {
 public:
  using BoxedPeer::BoxedPeer;

 protected:
  std::vector<float> solve(const PeerInput& input) override {
    const BoxGrid& grid = input.image.grid;
    const std::vector<float>& image = input.image.value;
    const CpuFieldExecutor executor(run());
    ParallelWalker<CpuFieldExecutor> walker(grid, {input.spacing[0], input.spacing[1], input.spacing[2]}, executor);
    float largest = 0;
    for (int axis = 0; axis < 3; ++axis)
      for (int v = 0; v + grid.stride(axis) < grid.count(); ++v)
        if (has_next(grid, v, axis)) largest = std::max(largest, std::abs(image[v + grid.stride(axis)] - image[v]));
    const float fall = largest > 0 ? kBeta / (largest * largest) : 0.0f;
    for (int axis = 0; axis < 3; ++axis) {
      const float scale = static_cast<float>(1 / (input.spacing[axis] * input.spacing[axis]));
      float* const weight = walker.conductances(axis);
      for (int v = 0; v < grid.count(); ++v) {
        const bool next = has_next(grid, v, axis);
        const float d = next ? image[v + grid.stride(axis)] - image[v] : 0.0f;
        const bool conducts = next && input.image.finite[v] && input.image.finite[v + grid.stride(axis)];
        weight[v] = conducts ? scale * (std::exp(-fall * d * d) + kLeastWeight) : 0.0f;
      }
    }
    std::vector<std::uint8_t> held(grid.count());
    const std::vector<std::uint8_t> target(grid.count());
    for (int v = 0; v < grid.count(); ++v) {
      held[v] = is_dirichlet(input.known[v]);
      walker.field()[v] = input.known[v] == Constraint::Inside || input.before[v] != 0;
      if (held[v]) walker.field()[v] = input.known[v] == Constraint::Inside;
      walker.prior_weight()[v] = 0;
    }
    walker.solve(target.data(), held.data(), kTolerance, kMostIterations);
    std::vector<float> field(grid.count());
    executor.download<float>(walker.field(), field);
    return field;
  }

 private:
  static bool has_next(const BoxGrid& grid, int v, int axis) {
    const std::array<int, 3> at{v % grid.row(), v % grid.plane() / grid.row(), v / grid.plane()};
    return at[axis] + 1 < grid.size[axis];
  }
};

}  // namespace

std::unique_ptr<RobotSubject> make_random_walker(const Volume& image, const RunJobs& run) {
  return std::make_unique<RandomWalkerPeer>(image, run);
}

}  // namespace simplexseg
