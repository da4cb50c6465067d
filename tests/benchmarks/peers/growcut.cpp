// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "peers/boxed_peer.h"
#include "peers/peers.h"

namespace simplexseg {
namespace {

/// Cell that has changed its label in the last pass, with the strength of its attack.
struct Cell {
  int voxel;
  float strength;
  bool inside;
};

/// GrowCut (Vezhnevets and Konouchine 2005): a cell p takes the label of a neighbour q if g(|C_p - C_q|) theta_q >
/// theta_p, with g(x) = 1 - x / max |C|; seeds have strength 1, other cells 0. All cells are updated at once, with von
/// Neumann's neighbourhood, until none changes. Only cells that changed in the last pass can change others.
class GrowCut : public BoxedPeer {
 public:
  using BoxedPeer::BoxedPeer;

 protected:
  std::vector<float> solve(const PeerInput& input) override {
    const BoxGrid& grid = input.image.grid;
    std::vector<float> strength(grid.count()), label(grid.count()), next(grid.count());
    std::vector<std::uint8_t> next_inside(grid.count());
    std::vector<Cell> front;
    std::vector<int> taken;
    for (int v = 0; v < grid.count(); ++v) {
      if (!is_dirichlet(input.known[v])) continue;
      strength[v] = next[v] = 1;
      label[v] = input.known[v] == Constraint::Inside;
      // Non-finite voxels have no intensity and do not attack.
      if (input.known[v] != Constraint::NotFinite) front.push_back({v, 1, label[v] > 0});
    }
    while (!front.empty()) {
      for (const Cell& cell : front) {
        const std::array<int, 3> at{cell.voxel % grid.row(), cell.voxel % grid.plane() / grid.row(),
                                    cell.voxel / grid.plane()};
        for (int side = 0; side < 6; ++side) {
          const int axis = side / 2, step = side % 2 ? 1 : -1;
          if (at[axis] + step < 0 || at[axis] + step == grid.size[axis]) continue;
          const int p = cell.voxel + step * grid.stride(axis);
          // Intensities lie in [0, 1].
          const float attack = cell.strength * (1 - std::abs(input.image.value[p] - input.image.value[cell.voxel]));
          if (!(attack > next[p])) continue;
          if (next[p] == strength[p]) taken.push_back(p);
          next[p] = attack;
          next_inside[p] = cell.inside;
        }
      }
      front.clear();
      for (const int p : taken) {
        strength[p] = next[p];
        label[p] = next_inside[p];
        front.push_back({p, strength[p], next_inside[p] != 0});
      }
      taken.clear();
    }
    return label;
  }
};

}  // namespace

std::unique_ptr<RobotSubject> make_growcut(const Volume& image, const RunJobs& run) {
  return std::make_unique<GrowCut>(image, run);
}

}  // namespace simplexseg
