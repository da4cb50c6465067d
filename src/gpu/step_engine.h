// SPDX-License-Identifier: Apache-2.0
// The engine: what a step is, once, for every executor. An executor owns memory (Array<T>) and runs kernels:
//   Array<T>: data(), size(), resize(n) (contents lost), upload(span), download(span), fill_zero(), swap
//   run(kernel, n): kernel(0) ... kernel(n-1), ordered after all earlier runs; skipped once a step has failed
//   bind(volume, view): makes the voxels readable and sets view.voxels
#pragma once
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/region_model.h"
#include "core/stability.h"
#include "core/volume.h"
#include "gpu/kernels.h"

namespace simplexseg {

template <class Executor>
class StepEngine final : public Engine {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  explicit StepEngine(Executor executor) : executor_(std::move(executor)) { status_.resize(1); }

  const char* backend() const override { return Executor::name; }
  std::string description() const override { return executor_.description(); }

  void set_volume(const Volume& volume) override {
    volume_ = volume;
    view_.volume = {};
    if (!volume_.empty()) {
      const VolumeGeometry& g = volume_.geometry();
      const Eigen::Matrix<double, 3, 4> m = g.index_from_world().matrix().topRows<3>();
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 4; ++c) view_.volume.index_from_world[4 * r + c] = static_cast<float>(m(r, c));
      for (int k = 0; k < 3; ++k) view_.volume.size[k] = g.size[k];
      const IntensityWindow window = intensity_window(volume_);
      view_.volume.intensity_low = static_cast<float>(window.low);
      view_.volume.intensity_scale = static_cast<float>(1.0 / (window.high - window.low));
    }
    executor_.bind(volume_, view_.volume);
    refresh_due_ = true;
  }

  void load(std::span<const EngineMesh> meshes, const SimulationParameters& simulation) override {
    long total = 0;
    for (const EngineMesh& m : meshes) total += static_cast<long>(m.positions.size());
    if (total > 500'000'000) throw Error("meshes", "more than 500 million vertices", "use fewer or coarser meshes");
    const int count = static_cast<int>(total);
    constants_.assign(meshes.size(), {});
    std::vector<Vec4> current(count), previous(count), shape(count);
    std::vector<Int4> neighbours(count);
    region_tables_host_.clear();
    references_.assign(meshes.size(), {});
    profiles_host_.clear();
    int first = 0;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const EngineMesh& m = meshes[k];
      const int n = static_cast<int>(m.positions.size());
      MeshConstants& c = constants_[k];
      c.first_vertex = first, c.vertex_count = n, c.finest = m.finest, c.forces = m.parameters, c.region_table = -1;
      double edges = 0;
      for (int i = 0; i < n; ++i) {
        const Eigen::Vector3f &x = m.positions[i], &q = m.previous[i];
        current[first + i] = {x[0], x[1], x[2], 0};
        previous[first + i] = {q[0], q[1], q[2], 0};
        const auto& nb = m.neighbours[i];
        neighbours[first + i] = {first + nb[0], first + nb[1], first + nb[2], static_cast<int>(k)};
        for (int j : nb) edges += (m.positions[j] - x).norm();
      }
      c.edge_mm = n > 0 ? static_cast<float>(edges / (3.0 * n)) : 0.0f;
      if (m.region && !m.region->empty()) {
        c.region_table = static_cast<int>(region_tables_host_.size());
        c.intensity_low = static_cast<float>(m.region->low);
        c.intensity_scale = static_cast<float>(1.0 / (m.region->high - m.region->low));
        const auto table = log_likelihood_ratios(*m.region);
        region_tables_host_.insert(region_tables_host_.end(), table.begin(), table.end());
      }
      references_[k].assign(m.shape.begin(), m.shape.end());
      if (!m.shape.empty()) std::copy(m.shape.begin(), m.shape.end(), shape.begin() + first);
      profiles_host_.emplace_back(m.profiles.begin(), m.profiles.end());
      first += n;
    }
    shape_host_ = std::move(shape);
    view_.vertex_count = count;
    view_.mesh_count = static_cast<int>(meshes.size());
    neighbours_.assign(neighbours);
    for (auto& x : positions_) x.resize(count);
    positions_[0].upload(previous);
    positions_[1].upload(current);
    oldest_ = 0;
    frame_.resize(count);
    frame_.fill_zero();
    motion_sums_.resize(constants_.size() * motion_blocks());
    points_.resize(0);
    points_host_.clear();
    view_.point_count = 0;
    for (auto* array : {&shape_, &gradient_target_, &profile_target_, &region_target_, &local_statistics_, &scratch_}) array->resize(0);
    profiles_.resize(0), region_tables_.resize(0);
    apply_parameters(simulation);
  }

  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation) override {
    for (std::size_t k = 0; k < constants_.size(); ++k) constants_[k].forces = meshes[k];
    apply_parameters(simulation);
  }

  void set_points(std::span<const EnginePoint> points) override {
    std::vector<PointView> list(points.size());
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector3f p = points[k].position_mm.cast<float>();
      list[k] = {{p[0], p[1], p[2], 0}, points[k].mesh, -1};
    }
    // What earlier bindings left in the sums would go on pulling.
    if (attraction_.size() != 0) attraction_.fill_zero();
    points_host_ = std::move(list);
    if (points_.size() != points_host_.size())
      points_.resize(0);
    else
      points_.upload(points_host_);
    view_.point_count = static_cast<int>(points_host_.size());
    hold_what_is_needed();
    refresh_due_ = true;
  }

  void refresh() override { refresh_due_ = true; }

  StepOutcome step(int count) override {
    StepOutcome outcome;
    if (view_.vertex_count == 0 || count <= 0) {
      outcome.steps = std::max(count, 0);
      outcome.mean_move_mm.assign(constants_.size(), 0.0f);
      return outcome;
    }
    const StepStatus none{~0ull};
    status_.upload(std::span(&none, 1));
    int done = 0;
    for (; done < count; ++done) {
      executor_.begin_step(status_.data(), static_cast<unsigned long long>(done));
      update_view();
      run(GeometryKernel{view_});
      if (refresh_due_ || since_refresh_ >= refresh_interval_) {
        find_targets();
        refresh_due_ = false;
        since_refresh_ = 0;
      }
      ++since_refresh_;
      if (active(ForceId::Attraction)) {
        run(ClearAttraction{view_}, view_.point_count * kMaxPatch);
        run(SumAttraction{view_}, view_.point_count * kMaxPatch);
      }
      integrate(static_cast<unsigned long long>(done));
      if (executor_.failed(status_.data())) break;
      oldest_ = (oldest_ + 1) % 3;
    }
    executor_.begin_step(status_.data(), 0);      // step 0: what follows runs also after a failure
    update_view();
    run(MotionOfBlocks{view_, motion_sums_.data(), motion_blocks()}, static_cast<int>(motion_sums_.size()));
    StepStatus status;
    status_.download(std::span(&status, 1));
    outcome.steps = done;
    if (status.failure != ~0ull) {
      const int failed_at = static_cast<int>(status.failure >> 40);
      // On a device, steps after the failed one were skipped, so the two poses before it are untouched.
      oldest_ = ((oldest_ - (done - failed_at)) % 3 + 3) % 3;
      const int vertex = static_cast<int>(status.failure >> 8 & 0xffffffffu);
      int mesh = 0;
      while (mesh + 1 < view_.mesh_count && vertex >= constants_[mesh + 1].first_vertex) ++mesh;
      outcome.steps = failed_at;
      outcome.failure = StepFailure{mesh, vertex - constants_[mesh].first_vertex, static_cast<ForceId>(status.failure & 0xff)};
      refresh_due_ = true;
    }
    std::vector<float> sums(motion_sums_.size());
    motion_sums_.download(sums);
    mean_moves(sums, outcome.mean_move_mm);
    return outcome;
  }

  void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) override {
    const MeshConstants& c = constants_.at(mesh);
    std::vector<Vec4> texels(c.vertex_count);
    auto copy = [&](Array<Vec4>& from, std::span<Eigen::Vector3f> to) {
      from.download(texels, c.first_vertex);
      for (int i = 0; i < c.vertex_count; ++i) to[i] = {texels[i].x, texels[i].y, texels[i].z};
    };
    copy(positions_[(oldest_ + 1) % 3], positions);
    copy(positions_[oldest_], previous);
  }

  std::vector<HeldArray> held_arrays() const override {
    std::vector<HeldArray> held;
    auto add = [&](const char* name, const auto& array) {
      if (array.size() != 0) held.push_back({name, array.bytes()});
    };
    if (!volume_.empty()) held.push_back({"volume", volume_.bytes()});
    held.push_back({"positions", positions_[0].bytes() * 3});
    add("neighbours", neighbours_), add("frame", frame_), add("shape reference", shape_);
    add("gradient targets", gradient_target_), add("profile targets", profile_target_), add("reference profiles", profiles_);
    add("region targets", region_target_), add("averaging", scratch_), add("local statistics", local_statistics_);
    add("region tables", region_tables_), add("attraction points", points_), add("attraction bindings", nearest_);
    add("attraction patches", patches_), add("attraction sums", attraction_), add("mesh constants", meshes_), add("motion", motion_sums_);
    return held;
  }
  std::size_t bytes_held() const override {
    std::size_t sum = 0;
    for (const HeldArray& a : held_arrays()) sum += a.bytes;
    return sum;
  }
  std::vector<KernelCount> kernel_counts() const override {
    std::vector<KernelCount> counts;
    for (const auto& [name, n] : launches_) counts.push_back({name, n});
    return counts;
  }

 private:
  template <class Kernel>
  void run(const Kernel& kernel, int n = -1) {
    ++launches_[Kernel::name];
    executor_.run(kernel, n < 0 ? view_.vertex_count : n);
  }

  void apply_parameters(const SimulationParameters& simulation) {
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      MeshConstants& c = constants_[k];
      const MeshNeeds needs = mesh_needs(static_cast<int>(k));
      for (const ForceInfo& force : force_list())
        if (!needs.acts(force.id)) c.forces.values[static_cast<int>(force.id)][0] = 0;
      const float dt = effective_timestep(simulation, stiffness_bound(c.forces, references_[k]));
      c.dt2 = dt * dt;
      c.keep = 1.0f - simulation.damping;
      c.voxel_mm = volume_.empty() ? 1.0f : static_cast<float>(volume_.geometry().spacing_mm.minCoeff());
    }
    refresh_interval_ = static_cast<int>(simulation.refresh_interval + 0.5f);
    meshes_.assign(constants_);
    hold_what_is_needed();
    refresh_due_ = true;
  }

  MeshNeeds mesh_needs(int k) const {
    const MeshConstants& c = constants_[k];
    return {c.forces, c.vertex_count, c.finest != 0, !references_[k].empty(), profiles_host_[k].size()};
  }
  bool active(ForceId force) const { return needs_.uses(force); }

  /// Each array is held exactly while the plan needs it.
  void hold_what_is_needed() {
    const std::size_t n = view_.vertex_count;
    std::vector<MeshNeeds> meshes;
    for (std::size_t k = 0; k < constants_.size(); ++k) meshes.push_back(mesh_needs(static_cast<int>(k)));
    needs_ = needs_of(meshes, !volume_.empty(), view_.point_count);
    auto hold = [&](auto& array, bool needed, std::size_t size) {
      if (!needed) array.resize(0);
      if (needed && array.size() != size) array.resize(size), array.fill_zero();
    };
    if (active(ForceId::ShapeMemory) && shape_.size() != n) shape_.assign(shape_host_);
    hold(shape_, active(ForceId::ShapeMemory), n);
    hold(gradient_target_, active(ForceId::Gradient), n);
    hold(profile_target_, active(ForceId::IntensityProfile), n);
    hold(region_target_, active(ForceId::Region), n);
    hold(local_statistics_, needs_.local_statistics, n);
    hold(scratch_, needs_.averages(), n);
    if (active(ForceId::Region) && region_tables_.size() != region_tables_host_.size()) region_tables_.assign(region_tables_host_);
    hold(region_tables_, active(ForceId::Region), region_tables_host_.size());
    if (active(ForceId::IntensityProfile)) {
      const std::size_t stride = needs_.profile_stride;
      if (profiles_.size() != n * stride) {
        std::vector<float> all(n * stride, 0.0f);
        for (std::size_t k = 0; k < constants_.size(); ++k) {
          // Also those that do not act now: they may later, within the same stride.
          const MeshConstants& c = constants_[k];
          const std::size_t length = c.vertex_count > 0 ? profiles_host_[k].size() / c.vertex_count : 0;
          if (length == 0 || length > stride || profiles_host_[k].size() != length * c.vertex_count) continue;
          for (int i = 0; i < c.vertex_count; ++i)
            std::copy_n(profiles_host_[k].begin() + i * length, length, all.begin() + (c.first_vertex + i) * stride);
        }
        profiles_.assign(all);
      }
      view_.profile_stride = static_cast<int>(stride);
    } else {
      profiles_.resize(0);
    }
    const bool attract = active(ForceId::Attraction);
    if (attract && points_.size() != points_host_.size()) points_.assign(points_host_);
    hold(points_, attract, points_host_.size());
    hold(nearest_, attract, view_.point_count);
    hold(patches_, attract, static_cast<std::size_t>(view_.point_count) * kMaxPatch);
    hold(attraction_, attract, n);
  }

  void update_view() {
    view_.meshes = meshes_.data(), view_.neighbours = neighbours_.data();
    view_.previous = positions_[oldest_].data(), view_.current = positions_[(oldest_ + 1) % 3].data();
    view_.next = positions_[(oldest_ + 2) % 3].data(), view_.frame = frame_.data(), view_.shape = shape_.data();
    view_.gradient_target = gradient_target_.data(), view_.profile_target = profile_target_.data();
    view_.region_target = region_target_.data(), view_.profiles = profiles_.data();
    view_.region_tables = region_tables_.data(), view_.local_statistics = local_statistics_.data();
    view_.points = points_.data(), view_.nearest = nearest_.data(), view_.patches = patches_.data();
    view_.attraction = attraction_.data(), view_.status = status_.data();
  }

  void find_targets() {
    if (needs_.searches())
      visit_voxel_type(volume_.type(), [&]<class T>(std::type_identity<T>) {
        if (active(ForceId::Gradient)) run(GradientSearch<T>{view_});
        if (active(ForceId::IntensityProfile)) run(ProfileSearch<T>{view_});
        if (active(ForceId::Region)) find_region_targets<T>();
      });
    if (active(ForceId::Attraction)) {
      nearest_.fill_ones();
      attraction_.fill_zero();
      const int blocks = (largest_mesh() + FindNearest::kBlock - 1) / FindNearest::kBlock;
      run(FindNearest{view_, blocks}, blocks * view_.point_count);
      run(BindPatch{view_}, view_.point_count);
    }
  }

  template <class T>
  void find_region_targets() {
    auto average = [&](Array<Vec4>& array, int passes, bool targets) {
      for (int pass = 0; pass < passes; ++pass) {
        run(AverageOverNeighbours{view_, array.data(), scratch_.data(), pass, targets});
        std::swap(array, scratch_);
        update_view();
      }
    };
    if (local_statistics_.size() != 0) {
      run(RegionStatistics<T>{view_});
      average(local_statistics_, kStatisticsPasses, false);
    }
    run(RegionSearch<T>{view_});
    average(region_target_, needs_.averaging_passes, true);
    run(RegionTarget{view_});
  }

  /// Calls the kernel compiled for exactly the forces in use.
  template <unsigned kMask = 0>
  void integrate(unsigned long long step) {
    if constexpr (kMask < 1u << kForceCount) {
      if (kMask == needs_.forces)
        run(IntegrateKernel<kMask>{view_, step});
      else
        integrate<kMask + 1>(step);
    }
  }

  void mean_moves(const std::vector<float>& sums, std::vector<float>& mean) const {
    mean.assign(constants_.size(), 0.0f);
    const int blocks = motion_blocks();
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      double sum = 0;
      for (int b = 0; b < blocks; ++b) sum += sums[k * blocks + b];
      if (constants_[k].vertex_count > 0) mean[k] = static_cast<float>(sum / constants_[k].vertex_count);
    }
  }
  int largest_mesh() const {
    int largest = 0;
    for (const MeshConstants& c : constants_) largest = std::max(largest, c.vertex_count);
    return largest;
  }
  int motion_blocks() const { return (largest_mesh() + MotionOfBlocks::kBlock - 1) / MotionOfBlocks::kBlock; }

  Executor executor_;
  Volume volume_;
  StepView view_;
  std::vector<MeshConstants> constants_;
  std::vector<std::vector<Vec4>> references_;
  std::vector<std::vector<float>> profiles_host_;
  std::vector<Vec4> shape_host_;
  std::vector<float> region_tables_host_;
  std::vector<PointView> points_host_;
  StepNeeds needs_;
  int refresh_interval_ = 1, since_refresh_ = 0;
  bool refresh_due_ = true;
  int oldest_ = 0;                  ///< of the three position arrays: previous, current, next from here on

  Array<MeshConstants> meshes_;
  Array<Int4> neighbours_;
  Array<Vec4> positions_[3], frame_, shape_, gradient_target_, profile_target_, region_target_, local_statistics_, scratch_;
  Array<float> profiles_, region_tables_, motion_sums_;
  Array<PointView> points_;
  Array<unsigned long long> nearest_;
  Array<PatchEntry> patches_;
  Array<AttractionSum> attraction_;
  Array<StepStatus> status_;
  std::map<std::string, std::uint64_t> launches_;
};

}  // namespace simplexseg
