// SPDX-License-Identifier: Apache-2.0
// Short and slow references for tests of the evidence field, and orders in which its jobs can run.
#pragma once
#include <cmath>
#include <cstdint>
#include <functional>
#include <memory>
#include <queue>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/thread_pool.h"
#include "field/box_grid.h"
#include "field/geodesic_distance.h"
#include "field/marked_voxels.h"
#include "field/run_jobs.h"

namespace simplexseg {

inline RunJobs run_in_reverse() {
  return [](int jobs, const std::function<void(int)>& job) {
    for (int j = jobs - 1; j >= 0; --j) job(j);
  };
}
inline RunJobs run_on_threads(int threads) {
  return [pool = std::make_shared<ThreadPool>(threads)](int jobs, const std::function<void(int)>& job) {
    pool->run(jobs, job);
  };
}
struct JobOrder {
  std::string name;
  RunJobs run;
};
/// Orders that must give the bits of run_serially().
inline std::vector<JobOrder> job_orders() {
  return {{"reversed", run_in_reverse()},
          {"1 thread", run_on_threads(1)},
          {"2 threads", run_on_threads(2)},
          {"8 threads", run_on_threads(8)}};
}

/// visit(i, j, k, v) for all cells of a grid.
template <class Visit>
void each_index(const BoxGrid& grid, const Visit& visit) {
  for (int k = 0, v = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++v) visit(i, j, k, v);
}
inline bool is_in(const BoxGrid& grid, int i, int j, int k) {
  return i >= 0 && j >= 0 && k >= 0 && i < grid.size[0] && j < grid.size[1] && k < grid.size[2];
}

/// Cells of a set that are connected over faces to one that is in `start`, too: flood fill.
inline std::vector<std::uint8_t> flooded(const std::vector<std::uint8_t>& set, const std::vector<std::uint8_t>& start,
                                         const BoxGrid& grid) {
  std::vector<std::uint8_t> reached(set.size());
  std::vector<int> open;
  const auto reach = [&](int v) {
    if (!set[v] || reached[v]) return;
    reached[v] = 1;
    open.push_back(v);
  };
  for (int v = 0; v < grid.count(); ++v)
    if (start[v]) reach(v);
  while (!open.empty()) {
    const int v = open.back();
    open.pop_back();
    const int at[3]{v % grid.row(), v / grid.row() % grid.size[1], v / grid.plane()};
    for (int a = 0; a < 3; ++a) {
      if (at[a] > 0) reach(v - grid.stride(a));
      if (at[a] + 1 < grid.size[a]) reach(v + grid.stride(a));
    }
  }
  return reached;
}

/// Geodesic distances over the 26 neighbours from the cells in `start`, at most `farthest`. Source: Dijkstra 1959.
inline std::vector<double> dijkstra(const std::vector<std::uint8_t>& start, const std::vector<float>& image,
                                    const BoxGrid& grid, const std::array<double, 3>& spacing_mm, const EdgeCost& cost,
                                    double farthest = 1e4) {
  const double least = std::min({spacing_mm[0], spacing_mm[1], spacing_mm[2]});
  std::vector<double> distance(start.size(), farthest);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (int v = 0; v < grid.count(); ++v)
    if (start[v]) queue.push({distance[v] = 0, v});
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    const int i = v % grid.row(), j = v / grid.row() % grid.size[1], k = v / grid.plane();
    for (int n = 0; n < 27; ++n) {
      const int di = n % 3 - 1, dj = n / 3 % 3 - 1, dk = n / 9 - 1;
      if (!is_in(grid, i + di, j + dj, k + dk)) continue;
      const int u = v + di + dj * grid.row() + dk * grid.plane();
      const double difference = std::fabs(double{image[u]} - image[v]), square = difference * difference;
      const double step = cost.edge > 0 ? square / (square + double{cost.edge} * cost.edge) : difference;
      const double length = std::hypot(di * spacing_mm[0], dj * spacing_mm[1], dk * spacing_mm[2]) / least;
      const double to = d + step + cost.length * length;
      if (to < distance[u] - 1e-12) queue.push({distance[u] = to, u});  // false for NaN
    }
  }
  return distance;
}

/// Sets the constraint of the voxels whose centres lie in a ball, and of the nearest one, unless they are not finite.
/// With OtherObject, only of voxels without a constraint.
inline void paint_ball(std::vector<Constraint>& constraints, const VolumeGeometry& geometry, const VoxelBox& box,
                       const Eigen::Vector3d& centre_mm, double radius_mm, Constraint value) {
  const Eigen::Affine3d world = geometry.world_from_index();
  const Eigen::Vector3d centre = geometry.index_from_world() * centre_mm;
  each_index({box.size}, [&](int i, int j, int k, int v) {
    const Eigen::Vector3d away = Eigen::Vector3d(box.first[0] + i, box.first[1] + j, box.first[2] + k) - centre;
    if (away.cwiseAbs().maxCoeff() > 0.5 && (world.linear() * away).norm() > radius_mm) return;
    if (constraints[v] == Constraint::NotFinite) return;
    if (value != Constraint::OtherObject || constraints[v] == Constraint::None) constraints[v] = value;
  });
}
/// Sets the constraints of the cells in the balls of marks, in their order.
inline void paint_marks(std::vector<Constraint>& constraints, const VolumeGeometry& geometry, const VoxelBox& box,
                        std::span<const Mark> marks) {
  for (const Mark& mark : marks) {
    const Eigen::Vector3d step = mark.kind == MarkKind::Boundary
                                     ? Eigen::Vector3d(mark.radius_mm * mark.outward / mark.outward.norm())
                                     : Eigen::Vector3d(0, 0, 0);
    if (mark.kind != MarkKind::Outside)
      paint_ball(constraints, geometry, box, mark.position_mm - step, mark.radius_mm, Constraint::Inside);
    if (mark.kind != MarkKind::Inside)
      paint_ball(constraints, geometry, box, mark.position_mm + step, mark.radius_mm, Constraint::Outside);
  }
}

}  // namespace simplexseg
