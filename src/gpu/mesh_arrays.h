// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/expect.h"
#include "forces/step_view.h"
#include "gpu/kernels.h"
#include "gpu/launcher.h"
#include "gpu/vertex_order.h"
#include "image/volume.h"
#include "mesh/mesh_geometry.h"
#include "step/engine.h"

namespace simplexseg {

/// Arrays of the vertices of all meshes, and constants of each mesh. The arrays contain the vertices of a mesh in patch
/// order (docs/adr/0009-vertex-order.md); the arguments of load() and read() have the original order.
template <class Executor>
class MeshArrays {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  /// Loads meshes. Uses the orders of those meshes of `before` that have the same neighbours. Throws Error, without any
  /// change, if they have more than 500 million vertices.
  void load(std::span<const EngineMesh> meshes, const MeshArrays& before) {
    long total = 0;
    for (const EngineMesh& m : meshes) total += static_cast<long>(m.positions.size());
    if (total > 500'000'000) throw Error("meshes", "more than 500 million vertices", "use fewer or coarser meshes");
    vertex_count_ = static_cast<int>(total);
    constants_.assign(meshes.size(), {});
    orders_.assign(meshes.size(), {}), loaded_neighbours_.assign(meshes.size(), {});
    boxes_.assign(meshes.size(), Eigen::AlignedBox3d());
    std::vector<Vec4> current(vertex_count_), previous(vertex_count_);
    std::vector<Int4> neighbours(vertex_count_);
    int first = 0;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const EngineMesh& m = meshes[k];
      SIMPLEXSEG_EXPECT(m.previous.size() == m.positions.size() && m.neighbours.size() == m.positions.size());
      const int n = static_cast<int>(m.positions.size());
      MeshConstants& c = constants_[k];
      // In patch order, neighbours are near each other in memory, which makes reads faster.
      loaded_neighbours_[k].assign(m.neighbours.begin(), m.neighbours.end());
      const auto same =
          std::find(before.loaded_neighbours_.begin(), before.loaded_neighbours_.end(), loaded_neighbours_[k]);
      orders_[k] = same != before.loaded_neighbours_.end() ? before.orders_[same - before.loaded_neighbours_.begin()]
                                                           : patch_order(m.neighbours);
      const std::vector<int>& order = orders_[k];
      std::vector<int> place(n);
      for (int i = 0; i < n; ++i) place[order[i]] = i;
      c.first_vertex = first, c.vertex_count = n, c.finest = m.finest, c.forces = m.parameters;
      c.region_table = -1;
      for (int to = 0; to < n; ++to) {
        const int i = order[to];
        const Eigen::Vector3f &x = m.positions[i], &q = m.previous[i];
        current[first + to] = {x[0], x[1], x[2], 0};
        previous[first + to] = {q[0], q[1], q[2], 0};
        const auto& nb = m.neighbours[i];
        neighbours[first + to] = {first + place[nb[0]], first + place[nb[1]], first + place[nb[2]],
                                  static_cast<int>(k)};
      }
      c.edge_mm = m.edge_mm > 0 ? m.edge_mm : mean_edge_mm(m.positions, m.neighbours);
      for (const Eigen::Vector3f& x : m.positions) boxes_[k].extend(x.cast<double>());
      first += n;
    }
    neighbours_.assign(neighbours);
    neighbours_host_ = std::move(neighbours);
    for (auto& x : positions_) x.resize(vertex_count_);
    positions_[0].upload(previous);
    positions_[1].upload(current), positions_[2].upload(current);
    frames_[0].resize(vertex_count_);
    frames_[0].fill_zero();
  }

  int vertex_count() const { return vertex_count_; }
  std::size_t size() const { return constants_.size(); }
  MeshConstants& operator[](std::size_t k) { return constants_[k]; }
  const MeshConstants& operator[](std::size_t k) const { return constants_[k]; }
  std::span<const MeshConstants> all() const { return constants_; }
  /// Restores previous constants of the same meshes.
  void restore(std::vector<MeshConstants> constants) { constants_ = std::move(constants); }
  /// For each mesh, the index in the loaded mesh of the vertex at each position of the patch order.
  std::span<const std::vector<int>> orders() const { return orders_; }
  std::span<const Int4> neighbours() const { return neighbours_host_; }
  int largest_mesh() const {
    int largest = 0;
    for (const MeshConstants& c : constants_) largest = std::max(largest, c.vertex_count);
    return largest;
  }
  int mesh_of(int vertex) const {
    int mesh = 0;
    while (mesh + 1 < static_cast<int>(constants_.size()) && vertex >= constants_[mesh + 1].first_vertex) ++mesh;
    return mesh;
  }

  /// Uploads the constants, which kernels read.
  void upload_constants() { device_constants_.assign(constants_); }

  /// Downloads the current positions of a mesh and those one step earlier, mm. `oldest`: as in StepPhase.
  void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous, int oldest) {
    const MeshConstants& c = constants_.at(mesh);
    SIMPLEXSEG_EXPECT(positions.size() == static_cast<std::size_t>(c.vertex_count) &&
                      previous.size() == positions.size());
    std::vector<Vec4> texels(c.vertex_count);
    auto copy = [&](Array<Vec4>& from, std::span<Eigen::Vector3f> to) {
      from.download(texels, c.first_vertex);
      const std::vector<int>& order = orders_[mesh];
      for (int i = 0; i < c.vertex_count; ++i) to[order[i]] = {texels[i].x, texels[i].y, texels[i].z};
    };
    copy(positions_[(oldest + 1) % 3], positions);
    copy(positions_[oldest], previous);
  }
  Vec4* positions_at(int array) { return positions_[array % 3].data(); }

  /// Sets the largest valid coordinate of each mesh, mm: start_distance_mm() plus ten times the diagonal of the scene,
  /// the bounding box of the loaded meshes, the points and the volume.
  void set_limits(const Volume& volume, std::span<const PointView> points) {
    constexpr double kSceneDiagonals = 10;
    Eigen::AlignedBox3d scene;
    for (const Eigen::AlignedBox3d& box : boxes_) scene.extend(box);
    for (const PointView& point : points)
      scene.extend(Eigen::Vector3d(point.position.x, point.position.y, point.position.z));
    if (!volume.empty())
      for (int corner = 0; corner < 8; ++corner) {
        Eigen::Vector3d index;
        for (int axis = 0; axis < 3; ++axis)
          index[axis] = (corner >> axis & 1) != 0 ? volume.geometry().size[axis] - 0.5 : -0.5;
        scene.extend(volume.geometry().world_from_index() * index);
      }
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      const double start = start_distance_mm(k);
      constants_[k].limit_mm =
          scene.isEmpty() ? 1.0f : static_cast<float>(start + kSceneDiagonals * scene.diagonal().norm() + 1e-6);
    }
  }
  /// Largest absolute coordinate of the centre of the bounding box of a mesh as loaded, mm.
  double start_distance_mm(std::size_t k) const {
    return boxes_[k].isEmpty() ? 0.0 : boxes_[k].center().cwiseAbs().maxCoeff();
  }

  void allocate_areas() { areas_.resize(vertex_count_), masses_.resize(vertex_count_); }
  void release_areas() { areas_.resize(0), masses_.resize(0); }

  // Frames are stored in one array, which a step updates in place, or in two: a step then reads the current array and
  // writes the other one. `at`: index of the current array.
  void allocate_second_frame(int at) {
    if (frames_[1].size() != 0) return;
    frames_[1].resize(vertex_count_), frames_[1].fill_zero();
    if (at == 1) std::swap(frames_[0], frames_[1]);
  }
  void release_second_frame(int at) {
    if (frames_[1].size() == 0) return;
    if (at == 1) std::swap(frames_[0], frames_[1]);
    frames_[1].resize(0);
  }
  /// Copies the current frames to the other array, if there are two: later steps do not compute those of sleeping
  /// meshes.
  void copy_frames(Launcher<Executor>& launcher, int at) {
    if (frames_[1].size() != 0) launcher.run(SavePose{frames_[at].texels(), other_frame(at), 0}, vertex_count_);
  }
  /// Array of frames that is not the current one.
  Vec4* other_frame(int at) { return frames_[1 - at].data(); }

  void fill_view(StepView& view, int oldest, int frame_at) {
    view.vertex_count = vertex_count_, view.mesh_count = static_cast<int>(constants_.size());
    view.meshes = device_constants_.data(), view.neighbours = neighbours_.texels();
    view.previous = positions_[oldest].texels(), view.current = positions_[(oldest + 1) % 3].texels();
    view.next = positions_[(oldest + 2) % 3].data(), view.oldest = positions_[oldest].data();
    Array<Vec4>& frame = frames_[frames_[1].size() != 0 ? frame_at : 0];
    view.frame = frame.texels(), view.new_frame = frame.data();
    view.areas = areas_.data(), view.masses = masses_.data();
  }
  /// Calls add(name, arrays...) for each group of arrays.
  template <class Add>
  void list_arrays(Add&& add) const {
    add("positions", positions_[0], positions_[1], positions_[2]);
    add("neighbours", neighbours_), add("frame", frames_[0], frames_[1]);
    add("areas", areas_), add("masses", masses_), add("mesh constants", device_constants_);
  }

 private:
  int vertex_count_ = 0;
  std::vector<MeshConstants> constants_;
  Array<MeshConstants> device_constants_;
  std::vector<std::vector<int>> orders_;
  std::vector<std::vector<std::array<int, 3>>> loaded_neighbours_;  ///< of each mesh, as given to load()
  std::vector<Eigen::AlignedBox3d> boxes_;                          ///< bounding box of each mesh as loaded, mm
  std::vector<Int4> neighbours_host_;
  typename Executor::NeighbourArray neighbours_;
  Array<Vec4> positions_[3], frames_[2];
  Array<float> areas_, masses_;
};

}  // namespace simplexseg
