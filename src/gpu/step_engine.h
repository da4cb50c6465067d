// SPDX-License-Identifier: Apache-2.0
// The engine: what a step is, once, for every executor. An executor owns memory and runs kernels:
//   Array<T>: data(), size(), resize(n) (contents lost), upload(span), download(span), fill_zero(); texels() of Vec4
//   NeighbourArray: the same for Int4, written once; texels()
//   HostVisible<T>: memory that kernels write and, after wait(), the host reads
//   run(kernel, n): kernel(0) ... kernel(n-1), ordered after all earlier runs; run_together(a, na, b, nb): both, in any order
//   record(body) -> Recording, replay(recording): where kRecords, runs that are kept and repeated at small cost
//   visit_width(n, f): f(how many lanes work on a search when there are n of them)
//   bind(volume, view): makes the voxels readable; visit_voxels(type, f): f(type identity of the sampler for them)
#pragma once
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include "core/error.h"
#include "core/region_model.h"
#include "core/simplex_mesh.h"
#include "core/stability.h"
#include "core/volume.h"
#include "gpu/display_kernels.h"
#include "gpu/kernels.h"
#include "gpu/vertex_order.h"

namespace simplexseg {

template <class Executor>
class StepEngine final : public Engine {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  explicit StepEngine(Executor executor) : executor_(std::move(executor)) {
    status_.resize(1), result_.resize(1);
    reset_status();
  }

  const char* backend() const override { return Executor::name; }
  std::string description() const override { return executor_.description(); }

  void set_volume(const Volume& volume) override {
    executor_.bind(volume, view_.volume);       // first: what does not fit changes nothing
    volume_ = volume;
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
    runs_.clear();
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
    orders_.assign(meshes.size(), {});
    cells_known_ = false, cell_count_ = 0;
    place_.resize(0), cell_first_.resize(0), cell_corners_.resize(0), drawn_.resize(0);
    region_tables_host_.clear();
    held_targets_.clear();
    references_.assign(meshes.size(), {});
    profiles_host_.clear();
    int first = 0;
    for (std::size_t k = 0; k < meshes.size(); ++k) {
      const EngineMesh& m = meshes[k];
      const int n = static_cast<int>(m.positions.size());
      MeshConstants& c = constants_[k];
      // Neighbours near each other in memory are read together.
      orders_[k] = patch_order(m.neighbours);
      const std::vector<int>& order = orders_[k];
      std::vector<int> place(n);
      for (int i = 0; i < n; ++i) place[order[i]] = i;
      c.first_vertex = first, c.vertex_count = n, c.finest = m.finest, c.forces = m.parameters, c.region_table = -1;
      double edges = 0;
      for (int to = 0; to < n; ++to) {
        const int i = order[to];
        const Eigen::Vector3f &x = m.positions[i], &q = m.previous[i];
        current[first + to] = {x[0], x[1], x[2], 0};
        previous[first + to] = {q[0], q[1], q[2], 0};
        const auto& nb = m.neighbours[i];
        neighbours[first + to] = {first + place[nb[0]], first + place[nb[1]], first + place[nb[2]], static_cast<int>(k)};
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
      if (!m.shape.empty())
        for (int to = 0; to < n; ++to) shape[first + to] = m.shape[order[to]];
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
    motion_.resize(constants_.size());
    points_.resize(0);
    points_host_.clear();
    view_.point_count = 0;
    for (auto* array : {&shape_, &gradient_target_, &profile_target_, &region_target_, &local_statistics_, &scratch_}) array->resize(0);
    profiles_.resize(0), region_tables_.resize(0), attraction_.resize(0), attracted_.resize(0);
    runs_.clear();
    reset_status();
    apply_parameters(simulation);
  }

  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation) override {
    for (std::size_t k = 0; k < constants_.size(); ++k) constants_[k].forces = meshes[k];
    apply_parameters(simulation);
  }

  void set_points(std::span<const EnginePoint> points) override {
    std::vector<PointView> list;
    list.reserve(points.size());
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      constants_[k].first_point = static_cast<int>(list.size());
      for (const EnginePoint& point : points) {
        if (point.mesh != static_cast<int>(k)) continue;
        const Eigen::Vector3f p = point.position_mm.cast<float>();
        list.push_back({{p[0], p[1], p[2], 0}, point.mesh, -1, -1, 0});
      }
      constants_[k].point_count = static_cast<int>(list.size()) - constants_[k].first_point;
    }
    if (!constants_.empty()) meshes_.upload(constants_);
    points_host_ = std::move(list);
    if (points_.size() != points_host_.size())
      points_.resize(0);
    else
      points_.upload(points_host_);
    view_.point_count = static_cast<int>(points_host_.size());
    int most = 0;
    for (const MeshConstants& c : constants_) most = std::max(most, c.point_count);
    view_.point_groups = (most + kPointGroup - 1) / kPointGroup;
    hold_what_is_needed();
    refresh_due_ = true;
  }

  void refresh() override { refresh_due_ = true; }

  void hold_targets(int mesh, ForceId force, std::span<const Vec4> targets) override {
    const MeshConstants& c = constants_.at(mesh);
    if (target_array(force) == nullptr || targets.size() != static_cast<std::size_t>(c.vertex_count))
      throw Error(std::string("targets of ") + force_list()[static_cast<int>(force)].name, "the force has none, or not as many", "give one for each vertex, of an image force");
    held_targets_.resize(constants_.size());
    std::vector<Vec4>& held = held_targets_[mesh][static_cast<int>(force)];
    held.resize(targets.size());
    for (int to = 0; to < c.vertex_count; ++to) held[to] = targets[orders_[mesh][to]];
    hold_what_is_needed();
  }
  void read_targets(int mesh, ForceId force, std::span<Vec4> targets) override {
    const MeshConstants& c = constants_.at(mesh);
    Array<Vec4>* array = target_array(force);
    std::fill(targets.begin(), targets.end(), Vec4{0, 0, 0, 0});
    if (array == nullptr || array->size() == 0) return;
    std::vector<Vec4> texels(c.vertex_count);
    array->download(texels, c.first_vertex);
    for (int i = 0; i < c.vertex_count; ++i) targets[orders_[mesh][i]] = texels[i];
  }

  StepOutcome step(int count) override {
    StepOutcome outcome;
    if (view_.vertex_count == 0 || count <= 0) {
      outcome.steps = std::max(count, 0);
      outcome.mean_move_mm.assign(constants_.size(), 0.0f);
      outcome.mean_edge_mm.assign(constants_.size(), 0.0f);
      outcome.residual_mm.assign(constants_.size(), 0.0f);
      outcome.folded_vertices.assign(constants_.size(), 0);
      outcome.inside_out.assign(constants_.size(), 0);
      return outcome;
    }
    [[maybe_unused]] const auto range = executor_.range("steps");
    int done = 0;
    while (done < count) {
      const int length = std::min(count - done, kLongestRun);
      const int ran = run_steps(length, done + length == count);
      done += ran;
      if (ran < length) {
        end_batch();
        break;
      }
    }
    executor_.wait();
    outcome.steps = done;
    const StepStatus status = result_.data()[0];
    if (status.failure != ~0ull) {
      const int failed_at = static_cast<int>(status.failure >> 40);
      // Steps after the failed one were skipped, so the two poses before it are untouched.
      oldest_ = ((oldest_ - (done - failed_at)) % 3 + 3) % 3;
      const int vertex = static_cast<int>(status.failure >> 8 & 0xffffffffu);
      int mesh = 0;
      while (mesh + 1 < view_.mesh_count && vertex >= constants_[mesh + 1].first_vertex) ++mesh;
      outcome.steps = failed_at;
      outcome.failure = StepFailure{mesh, orders_[mesh][vertex - constants_[mesh].first_vertex], static_cast<ForceId>(status.failure & 0xff)};
      if (attraction_.size() != 0) attraction_.fill_zero();
      refresh_due_ = true;
    }
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      outcome.mean_move_mm.push_back(motion_.data()[k].mean_move_mm);
      outcome.mean_edge_mm.push_back(motion_.data()[k].mean_edge_mm);
      float weights = 0;
      for (const ForceInfo& force : force_list()) weights += active(force.id) ? constants_[k].forces.weight(force.id) : 0.0f;
      outcome.residual_mm.push_back(weights > 0 ? std::sqrt(std::max(motion_.data()[k].mean_square_force, 0.0f)) / weights : 0.0f);
      outcome.folded_vertices.push_back(static_cast<int>(motion_.data()[k].folded));
      outcome.inside_out.push_back(motion_.data()[k].volume < 0);
    }
    return outcome;
  }

  void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) override {
    const MeshConstants& c = constants_.at(mesh);
    std::vector<Vec4> texels(c.vertex_count);
    auto copy = [&](Array<Vec4>& from, std::span<Eigen::Vector3f> to) {
      from.download(texels, c.first_vertex);
      const std::vector<int>& order = orders_[mesh];
      for (int i = 0; i < c.vertex_count; ++i) to[order[i]] = {texels[i].x, texels[i].y, texels[i].z};
    };
    copy(positions_[(oldest_ + 1) % 3], positions);
    copy(positions_[oldest_], previous);
  }

  std::unique_ptr<SharedBuffer> share_buffer(unsigned gl_buffer, std::size_t bytes) override { return executor_.share_buffer(gl_buffer, bytes); }

  void set_cells(std::span<const CellList* const> cells) override {
    if (cells.size() != constants_.size()) throw Error("cells", "not one list for each mesh", "give the cells of the meshes that were loaded");
    std::vector<int> first{0}, corners, place(view_.vertex_count);
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      const MeshConstants& c = constants_[k];
      std::vector<int> inverse(c.vertex_count);
      for (int i = 0; i < c.vertex_count; ++i) inverse[orders_[k][i]] = i;
      for (int cell = 0; cell < cells[k]->count(); ++cell) {
        for (int corner : (*cells[k])[cell]) {
          if (corner < 0 || corner >= c.vertex_count) throw Error("cells", "a corner is no vertex of the mesh", "give the cells of the meshes that were loaded");
          corners.push_back(c.first_vertex + inverse[corner]);
        }
        first.push_back(static_cast<int>(corners.size()));
      }
      for (int i = 0; i < c.vertex_count; ++i) place[c.first_vertex + i] = c.first_vertex + orders_[k][i];
    }
    cell_count_ = static_cast<int>(first.size()) - 1;
    cell_first_.assign(first), cell_corners_.assign(corners), place_.assign(place);
    cells_known_ = true;
  }
  bool has_cells() const override { return cells_known_; }

  void draw_surfaces(DrawTarget<DisplayPoint> target) override {
    if (!cells_known_) throw Error("surfaces", "their cells are not known", "call set_cells after a load");
    [[maybe_unused]] const auto range = executor_.range("draw surfaces");
    const std::size_t n = static_cast<std::size_t>(view_.vertex_count) + cell_count_;
    if (n == 0) return;
    executor_.draw(target, n, drawn_, [&](DisplayPoint* points) {
      update_view();
      run(DrawVertices{view_, place_.data(), points});
      run(DrawCells{cell_first_.data(), cell_corners_.data(), place_.data(), points, view_.vertex_count}, cell_count_);
    });
  }

  void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) override {
    if (!cells_known_) throw Error("outlines", "the cells are not known", "call set_cells after a load");
    [[maybe_unused]] const auto range = executor_.range("draw outlines");
    const std::size_t bytes = outline_bytes(constants_.size(), view_.vertex_count);
    if (bytes == 0) return;
    executor_.draw(target, bytes, drawn_outlines_, [&](std::byte* memory) {
      update_view();
      auto* commands = reinterpret_cast<OutlineCommand*>(memory);
      auto* pieces = reinterpret_cast<OutlinePiece*>(memory + constants_.size() * sizeof(OutlineCommand));
      run(BeginOutlines{view_.meshes, commands}, view_.mesh_count);
      run(DrawOutlines{view_, cell_first_.data(), cell_corners_.data(), axis, position_mm, commands, pieces}, cell_count_);
    });
  }

  void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) override {
    const std::size_t n = static_cast<std::size_t>(std::max(plane.width, 0)) * std::max(plane.height, 0);
    if (volume_.empty() || n == 0) return;
    [[maybe_unused]] const auto range = executor_.range("draw slice");
    executor_.draw(target, n, drawn_slice_, [&](DisplayTexel* texels) {
      executor_.visit_voxels(volume_.type(), [&]<class Voxels>(std::type_identity<Voxels>) { run(DrawSlice<Voxels>{view_.volume, plane, texels}, static_cast<int>(n)); });
    });
  }
  std::uint64_t bytes_read_back() const override { return executor_.bytes_read_back(); }

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
    add("attraction patches", patches_), add("attraction sums", attraction_), add("attraction flags", attracted_), add("mesh constants", meshes_), add("motion", motion_sums_);
    add("drawing", place_), add("cells", cell_corners_), add("cell ends", cell_first_), add("drawn surfaces", drawn_), add("drawn slice", drawn_slice_), add("drawn outlines", drawn_outlines_);
    return held;
  }
  std::size_t bytes_available() const override {
    const std::size_t free = executor_.bytes_free();
    return free > std::numeric_limits<std::size_t>::max() - bytes_held() ? free : free + bytes_held();
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
  static constexpr int kLongestRun = 30;     ///< steps of one recording: a multiple of 3, of 2 and of 5

  template <class Kernel>
  void run(const Kernel& kernel, int n = -1) {
    ++launches_[Kernel::name];
    executor_.run(kernel, n < 0 ? view_.vertex_count : n);
  }
  template <class A, class B>
  void run_together(const A& a, int na, const B& b, int nb) {
    ++launches_[A::name], ++launches_[B::name];
    executor_.run_together(a, na, b, nb);
  }
  void reset_status() {
    const StepStatus none;
    status_.upload(std::span(&none, 1));
  }

  /// What a recorded run depends on besides the plan, and what it leaves behind.
  struct Phase {
    int oldest, since_refresh;
    bool refresh_due;
    auto operator<=>(const Phase&) const = default;
  };
  struct RunKey {
    Phase phase;
    int length;
    bool last;
    auto operator<=>(const RunKey&) const = default;
  };
  struct Run {
    bool recorded = false;
    typename Executor::Recording recording;
    Phase after;
    std::map<std::string, std::uint64_t> launches;
  };

  /// `length` steps, and the end of the batch when `last`. Returns how many were done before a failure that the host knows of.
  int run_steps(int length, bool last) {
    if constexpr (!Executor::kRecords) {
      return do_steps(length, last);
    } else {
      const RunKey key{{oldest_, since_refresh_, refresh_due_}, length, last};
      auto found = runs_.find(key);
      if (found == runs_.end()) {
        // Recording costs as much as many launches: only what comes again is worth it.
        constexpr std::size_t kMostRuns = 100;
        if (runs_.size() >= kMostRuns) runs_.clear();
        runs_.emplace(key, Run{});
        return do_steps(length, last);
      }
      Run& run = found->second;
      if (!run.recorded) {
        const auto before = launches_;
        run.recording = executor_.record([&] { do_steps(length, last); });
        run.after = {oldest_, since_refresh_, refresh_due_};
        for (const auto& [name, n] : launches_) {
          const auto was = before.find(name);
          const std::uint64_t more = n - (was == before.end() ? 0 : was->second);
          if (more != 0) run.launches[name] = more;
        }
        run.recorded = true;
      } else {
        oldest_ = run.after.oldest, since_refresh_ = run.after.since_refresh, refresh_due_ = run.after.refresh_due;
        for (const auto& [name, n] : run.launches) launches_[name] += n;
      }
      executor_.replay(run.recording);
      return length;
    }
  }

  int do_steps(int length, bool last) {
    for (int k = 0; k < length; ++k)
      if (!do_step(k, k == 0 ? length : 0, last && k + 1 == length)) return k;
    if (last) end_batch();
    return length;
  }

  /// False when the step failed and the host knows.
  bool do_step(int of_run, int run_length, bool measure) {
    update_view();
    const bool refresh = refresh_due_ || since_refresh_ >= refresh_interval_;
    if (refresh) since_refresh_ = 0, refresh_due_ = false;
    ++since_refresh_;
    const bool attract = active(ForceId::Attraction);
    const GeometryKernel geometry{view_, run_length, attract && refresh};
    const int n = view_.vertex_count;
    if (!attract)
      run(geometry);
    else if (refresh)
      run_together(geometry, n, FindNearest{view_}, view_.mesh_count * view_.nearest_blocks * view_.point_groups);
    else
      run_together(geometry, n, SumAttraction{view_}, view_.point_count);
    if (refresh) find_targets(attract);
    integrate(of_run, measure);
    if (executor_.failed(status_.data())) return false;
    oldest_ = (oldest_ + 1) % 3;
    return true;
  }

  void end_batch() {
    update_view();
    run(MotionOfBlocks{view_, motion_sums_.data(), motion_blocks()}, static_cast<int>(motion_sums_.size()));
    run(EndOfBatch{view_, motion_sums_.data(), motion_blocks(), motion_.data(), result_.data()}, view_.mesh_count);
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
    MeshNeeds needs{c.forces, c.vertex_count, c.finest != 0, !references_[k].empty(), profiles_host_[k].size()};
    if (!held_targets_.empty())
      for (const ForceInfo& force : force_list())
        if (!held_targets_[k][static_cast<int>(force.id)].empty()) needs.held |= bit(force.id);
    return needs;
  }
  bool active(ForceId force) const { return needs_.uses(force); }
  /// Null for a force without targets.
  Array<Vec4>* target_array(ForceId force) {
    return force == ForceId::Gradient ? &gradient_target_ : force == ForceId::IntensityProfile ? &profile_target_ : force == ForceId::Region ? &region_target_ : nullptr;
  }

  /// Each array is held exactly while the plan needs it.
  void hold_what_is_needed() {
    const StepNeeds needed_before = needs_;
    const StepView view_before = view_;
    const int interval_before = recorded_interval_;
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
    for (std::size_t k = 0; k < held_targets_.size(); ++k)
      for (const ForceInfo& force : force_list()) {
        const std::vector<Vec4>& held = held_targets_[k][static_cast<int>(force.id)];
        if (!held.empty() && active(force.id)) target_array(force.id)->upload(held, constants_[k].first_vertex);
      }
    hold(local_statistics_, needs_.local_statistics, n);
    hold(scratch_, needs_.averages(), n);
    const bool regions = needs_.searches(ForceId::Region);
    if (regions && region_tables_.size() != region_tables_host_.size()) region_tables_.assign(region_tables_host_);
    hold(region_tables_, regions, region_tables_host_.size());
    if (needs_.searches(ForceId::IntensityProfile)) {
      const std::size_t stride = needs_.profile_stride;
      if (profiles_.size() != n * stride) {
        std::vector<float> all(n * stride, 0.0f);
        for (std::size_t k = 0; k < constants_.size(); ++k) {
          // Also those that do not act now: they may later, within the same stride.
          const MeshConstants& c = constants_[k];
          const std::size_t length = c.vertex_count > 0 ? profiles_host_[k].size() / c.vertex_count : 0;
          if (length == 0 || length > stride || profiles_host_[k].size() != length * c.vertex_count) continue;
          for (int i = 0; i < c.vertex_count; ++i)
            std::copy_n(profiles_host_[k].begin() + orders_[k][i] * length, length, all.begin() + (c.first_vertex + i) * stride);
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
    view_.nearest_blocks = needs_.nearest_blocks;
    hold(nearest_, attract, static_cast<std::size_t>(view_.point_count) * needs_.nearest_blocks);
    if (attract) nearest_.fill_ones();
    hold(patches_, attract, static_cast<std::size_t>(view_.point_count) * kMaxPatch);
    hold(attraction_, attract, n);
    hold(attracted_, attract, n);
    // What earlier bindings left in the sums would go on pulling.
    if (attract) attraction_.fill_zero();
    update_view();
    recorded_interval_ = refresh_interval_;
    // Recorded runs hold the addresses and the plan.
    if (!(needed_before == needs_) || interval_before != refresh_interval_ || !same_addresses(view_before, view_)) runs_.clear();
  }

  static bool same_addresses(StepView a, StepView b) {
    // The three position arrays take turns.
    a.previous = b.previous, a.current = b.current, a.next = b.next, a.oldest = b.oldest;
    static_assert(std::is_trivially_copyable_v<StepView>);
    return std::memcmp(&a, &b, sizeof a) == 0;
  }

  void update_view() {
    view_.meshes = meshes_.data(), view_.neighbours = neighbours_.texels();
    view_.previous = positions_[oldest_].texels(), view_.current = positions_[(oldest_ + 1) % 3].texels();
    view_.next = positions_[(oldest_ + 2) % 3].data(), view_.oldest = positions_[oldest_].data(), view_.frame = frame_.texels(), view_.new_frame = frame_.data();
    view_.shape = shape_.texels();
    view_.gradient_target = gradient_target_.data(), view_.profile_target = profile_target_.data();
    view_.region_target = region_target_.data(), view_.profiles = profiles_.data();
    view_.region_tables = region_tables_.data(), view_.local_statistics = local_statistics_.data();
    view_.points = points_.data(), view_.nearest = nearest_.data(), view_.patches = patches_.data();
    view_.attraction = attraction_.data(), view_.attracted = attracted_.data(), view_.status = status_.data();
  }

  /// `bind`: attraction patches too, beside the first search.
  void find_targets(bool bind) {
    auto search = [&](const auto& kernel) {
      if (bind)
        run_together(kernel, view_.vertex_count, BindPatch{view_}, view_.point_count);
      else
        run(kernel);
      bind = false;
    };
    if (needs_.searches())
      executor_.visit_voxels(volume_.type(), [&]<class Voxels>(std::type_identity<Voxels>) {
        executor_.visit_width(view_.vertex_count, [&]<int kWidth>(std::integral_constant<int, kWidth>) {
          if (needs_.searches(ForceId::Gradient)) search(GradientSearch<Voxels, kWidth>{view_, kWidth > 1 ? needs_.gradient_scratch : 0});
          if (needs_.searches(ForceId::IntensityProfile)) search(ProfileSearch<Voxels, kWidth>{view_, needs_.profile_scratch});
          if (!needs_.searches(ForceId::Region)) return;
          if (local_statistics_.size() != 0) {
            using Statistics = RegionStatistics<Voxels, kWidth>;
            search(Statistics{view_, Statistics::kCount});
            average(local_statistics_.data(), kStatisticsPasses, false);
            static_assert(kStatisticsPasses % 2 == 0, "so that the averages end where they are read");
          }
          search(RegionSearch<Voxels, kWidth>{view_, needs_.region_scratch});
          run(RegionTarget{view_, average(region_target_.data(), needs_.averaging_passes, true)});
        });
      });
    if (bind) run(BindPatch{view_}, view_.point_count);
  }

  /// Back and forth between an array and scratch_; returns where the result is.
  const Vec4* average(Vec4* values, int passes, bool targets) {
    Vec4 *from = values, *to = scratch_.data();
    for (int pass = 0; pass < passes; ++pass) {
      run(AverageOverNeighbours{view_, from, to, pass, targets});
      std::swap(from, to);
    }
    return from;
  }

  /// Calls the kernel compiled for exactly the forces in use.
  template <unsigned kMask = 0>
  void integrate(int step, bool measure) {
    if constexpr (kMask < 1u << kForceCount) {
      if (kMask == needs_.forces)
        run(IntegrateKernel<kMask>{view_, step, measure});
      else
        integrate<kMask + 1>(step, measure);
    }
  }

  int largest_mesh() const {
    int largest = 0;
    for (const MeshConstants& c : constants_) largest = std::max(largest, c.vertex_count);
    return largest;
  }
  int motion_blocks() const { return (largest_mesh() + MotionOfBlocks::kBlock - 1) / MotionOfBlocks::kBlock; }

  Executor executor_;            // first: arrays go before the device they live on
  Volume volume_;
  StepView view_;
  std::vector<MeshConstants> constants_;
  std::vector<std::vector<int>> orders_;     ///< of each mesh: the vertex, as it was loaded, at each place
  std::vector<std::vector<Vec4>> references_;
  std::vector<std::array<std::vector<Vec4>, kForceCount>> held_targets_;     ///< of each mesh and force; empty: none at all
  std::vector<std::vector<float>> profiles_host_;
  std::vector<Vec4> shape_host_;
  std::vector<float> region_tables_host_;
  std::vector<PointView> points_host_;
  StepNeeds needs_;
  int refresh_interval_ = 1, since_refresh_ = 0, recorded_interval_ = 0;
  bool refresh_due_ = true;
  int oldest_ = 0;                  ///< of the three position arrays: previous, current, next from here on

  Array<MeshConstants> meshes_;
  typename Executor::NeighbourArray neighbours_;
  Array<Vec4> positions_[3], frame_, shape_, gradient_target_, profile_target_, region_target_, local_statistics_, scratch_;
  Array<float> profiles_, region_tables_;
  Array<MeshMotion> motion_sums_;
  Array<PointView> points_;
  Array<unsigned long long> nearest_;
  Array<PatchEntry> patches_;
  Array<AttractionSum> attraction_;
  Array<std::uint8_t> attracted_;
  Array<StepStatus> status_;
  typename Executor::template HostVisible<StepStatus> result_;
  typename Executor::template HostVisible<MeshMotion> motion_;
  Array<int> place_, cell_first_, cell_corners_;   ///< for drawing
  Array<DisplayPoint> drawn_;                       ///< where they are not drawn into a shared buffer
  Array<DisplayTexel> drawn_slice_;
  Array<std::byte> drawn_outlines_;
  bool cells_known_ = false;
  int cell_count_ = 0;
  std::map<RunKey, Run> runs_;
  std::map<std::string, std::uint64_t> launches_;
};

}  // namespace simplexseg
