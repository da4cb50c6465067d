// SPDX-License-Identifier: Apache-2.0
// The engine: what a step is, once, for every executor. An executor owns memory and runs kernels:
//   Array<T>: data(), size(), resize(n) (contents lost), upload(span), download(span), fill_zero(); texels() of Vec4
//   NeighbourArray: the same for Int4, written once; texels()
//   HostVisible<T>: memory that kernels write and, after wait(), the host reads
//   run(kernel, n): kernel(0) ... kernel(n-1), ordered after all earlier runs; run_together(a, na, b, nb): both, in any
//   order; run(kernel): kernel(team), where it is written for one record(body) -> Recording, replay(recording): where
//   kRecords, runs that are kept and repeated at small cost visit_width(n, f): f(how many lanes work on a search when
//   there are n of them) bind(volume, view): makes the voxels readable; visit_voxels(type, f): f(type identity of the
//   sampler for them)
#pragma once
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include "core/error.h"
#include "forces/region_model.h"
#include "gpu/fold_watch.h"
#include "gpu/kernels.h"
#include "gpu/levels.h"
#include "gpu/recorded_runs.h"
#include "gpu/surface_drawing.h"
#include "gpu/vertex_order.h"
#include "image/volume.h"
#include "mesh/simplex_mesh.h"
#include "step/simulation_parameters.h"
#include "step/stability.h"

namespace simplexseg {

template <class Executor>
class StepEngine final : public Engine {
  template <class T>
  using Array = typename Executor::template Array<T>;

 public:
  explicit StepEngine(Executor executor) : launcher_{std::move(executor)} {
    status_.resize(1), result_.resize(1);
    reset_status();
  }

  const char* backend() const override { return Executor::name; }
  std::string description() const override { return executor().description(); }

  void set_volume(const Volume& volume) override {
    executor().bind(volume, view_.volume);  // first: what does not fit changes nothing
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
    phase_.refresh_due = true;
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
    drawing_.forget_cells();
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
        neighbours[first + to] = {first + place[nb[0]], first + place[nb[1]], first + place[nb[2]],
                                  static_cast<int>(k)};
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
    neighbours_host_ = std::move(neighbours);
    learnt_.clear(), wanted_.clear();
    for (const EngineMesh& m : meshes) learnt_.push_back(m.solver), wanted_.push_back(m.parameters);
    box_.assign(meshes.size(), Eigen::AlignedBox3d());
    for (std::size_t k = 0; k < meshes.size(); ++k)
      for (const Eigen::Vector3f& x : meshes[k].positions) box_[k].extend(x.cast<double>());
    levels_.forget();
    hold_known_ = false;
    kept_.resize(0);
    folds_.forget();
    for (auto& x : positions_) x.resize(count);
    positions_[0].upload(previous);
    positions_[1].upload(current);
    phase_.oldest = 0;
    frame_.resize(count);
    frame_.fill_zero();
    motion_sums_.resize(constants_.size() * motion_blocks());
    motion_.resize(constants_.size());
    points_.resize(0);
    points_host_.clear();
    view_.point_count = 0;
    for (auto* array : {&shape_, &gradient_target_, &profile_target_, &region_target_, &local_statistics_, &scratch_})
      array->resize(0);
    profiles_.resize(0), region_tables_.resize(0), attraction_.resize(0), attracted_.resize(0);
    runs_.clear();
    reset_status();
    apply_parameters(simulation);
  }

  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& simulation) override {
    wanted_.assign(meshes.begin(), meshes.end());
    learnt_.assign(constants_.size(), {});
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
    points_host_ = std::move(list);
    note_limits();
    for (std::size_t k = 0; k < controls_.size(); ++k) controls_[k].set_points(constants_[k].point_count);
    if (!constants_.empty()) meshes_.upload(constants_);
    if (points_.size() != points_host_.size())
      points_.resize(0);
    else
      points_.upload(points_host_);
    view_.point_count = static_cast<int>(points_host_.size());
    int most = 0;
    for (const MeshConstants& c : constants_) most = std::max(most, c.point_count);
    view_.point_groups = (most + kPointGroup - 1) / kPointGroup;
    if (forms_changed())
      apply_forms();
    else
      hold_what_is_needed();
    phase_.refresh_due = true;
  }

  void refresh() override { phase_.refresh_due = true; }

  void hold_targets(int mesh, ForceId force, std::span<const Vec4> targets) override {
    const MeshConstants& c = constants_.at(mesh);
    if (target_array(force) == nullptr || targets.size() != static_cast<std::size_t>(c.vertex_count))
      throw Error(std::string("targets of ") + force_list()[static_cast<int>(force)].name,
                  "the force has none, or not as many", "give one for each vertex, of an image force");
    held_targets_.resize(constants_.size());
    std::vector<Vec4>& held = held_targets_[mesh][static_cast<int>(force)];
    held.resize(targets.size());
    for (int to = 0; to < c.vertex_count; ++to) held[to] = targets[orders_[mesh][to]];
    apply_parameters(simulation_);  // now the force acts
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
      for (const SolverControl& control : controls_) outcome.solver.push_back(control.state());
      return outcome;
    }
    [[maybe_unused]] const auto range = executor().range("steps");
    while (outcome.steps < count && !outcome.failure) {
      // One batch: to the end of the interval after which the solvers look at what they did, or all of it.
      const bool watched = watched_;
      // What is not known before a first step: what holds the meshes, and which of them are folded.
      const bool folds_unknown = kept_.size() != 0 && !folds_.knows(constants_.size());
      const bool first = (corrected_ && !hold_known_) || folds_unknown;
      const int wanted = std::min(count - outcome.steps, first     ? 1
                                                         : watched ? SolverControl::kInterval - since_watched_
                                                                   : count);
      const bool interval_ends = watched && since_watched_ + wanted == SolverControl::kInterval;
      if (kept_.size() != 0 && since_watched_ == 0) keep_pose();
      int done = 0;
      while (done < wanted) {
        const int length = std::min(wanted - done, kLongestRun);
        send_coefficients();
        const int ran = run_steps(length, done + length < wanted ? End::None
                                          : interval_ends        ? End::Interval
                                                                 : End::Batch);
        done += ran;
        if (ran < length) {
          end_batch();
          break;
        }
      }
      executor().wait();
      const StepStatus status = result_.data()[0];
      if (status.failure != ~0ull) {
        const int failed_at = static_cast<int>(status.failure >> 40);
        // Steps after the failed one were skipped, so the two poses before it are untouched.
        phase_.oldest = ((phase_.oldest - (done - failed_at)) % 3 + 3) % 3;
        outcome.steps += failed_at;
        const int vertex = static_cast<int>(status.failure >> 8 & 0xffffffffu);
        int mesh = 0;
        while (mesh + 1 < view_.mesh_count && vertex >= constants_[mesh + 1].first_vertex) ++mesh;
        undo({mesh, orders_[mesh][vertex - constants_[mesh].first_vertex], static_cast<ForceId>(status.failure & 0xff)},
             outcome);
      } else {
        outcome.steps += done;
        since_watched_ = watched ? (since_watched_ + done) % SolverControl::kInterval : 0;
        if (folds_unknown) folds_.begin(constants_, motion_.data());
        if (corrected_ && !hold_known_) note_hold();
        if (interval_ends) learn(outcome);
      }
    }
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      outcome.mean_move_mm.push_back(motion_.data()[k].mean_move_mm);
      outcome.mean_edge_mm.push_back(motion_.data()[k].mean_edge_mm);
      outcome.residual_mm.push_back(residual_mm(k));
      outcome.folded_vertices.push_back(static_cast<int>(motion_.data()[k].folded));
      outcome.inside_out.push_back(motion_.data()[k].volume < 0);
      outcome.solver.push_back(controls_[k].state());
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
    copy(positions_[(phase_.oldest + 1) % 3], positions);
    copy(positions_[phase_.oldest], previous);
  }

  std::unique_ptr<SharedBuffer> share_buffer(unsigned gl_buffer, std::size_t bytes) override {
    return executor().share_buffer(gl_buffer, bytes);
  }

  void set_cells(std::span<const CellList* const> cells) override {
    drawing_.set_cells(cells, constants_, orders_, view_.vertex_count);
  }
  bool has_cells() const override { return drawing_.knows_cells(); }

  void draw_surfaces(DrawTarget<DisplayPoint> target) override {
    [[maybe_unused]] const auto range = executor().range("draw surfaces");
    update_view();
    drawing_.draw_surfaces(launcher_, view_, target);
  }
  void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) override {
    [[maybe_unused]] const auto range = executor().range("draw outlines");
    update_view();
    drawing_.draw_outlines(launcher_, view_, axis, position_mm, target);
  }
  void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) override {
    [[maybe_unused]] const auto range = executor().range("draw slice");
    if (!volume_.empty()) drawing_.draw_slice(launcher_, view_.volume, volume_.type(), plane, target);
  }
  std::uint64_t bytes_read_back() const override { return executor().bytes_read_back(); }

  std::vector<HeldArray> held_arrays() const override {
    std::vector<HeldArray> held;
    auto add = [&](const char* name, const auto&... arrays) {
      if (const std::size_t bytes = (arrays.bytes() + ...); bytes != 0) held.push_back({name, bytes});
    };
    if (!volume_.empty()) held.push_back({"volume", volume_.bytes()});
    held.push_back({"positions", positions_[0].bytes() * 3});
    add("neighbours", neighbours_), add("frame", frame_), add("shape reference", shape_);
    add("gradient targets", gradient_target_), add("profile targets", profile_target_),
        add("reference profiles", profiles_);
    add("region targets", region_target_), add("averaging", scratch_), add("local statistics", local_statistics_);
    add("region tables", region_tables_), add("attraction points", points_), add("attraction bindings", nearest_);
    add("attraction patches", patches_), add("attraction sums", attraction_), add("attraction flags", attracted_),
        add("mesh constants", meshes_), add("step coefficients", coefficients_), add("motion", motion_sums_);
    levels_.list(add);
    add("kept pose", kept_);
    drawing_.list(add);
    return held;
  }
  std::size_t bytes_available() const override {
    const std::size_t free = executor().bytes_free();
    return free > std::numeric_limits<std::size_t>::max() - bytes_held() ? free : free + bytes_held();
  }
  std::size_t bytes_held() const override {
    std::size_t sum = 0;
    for (const HeldArray& a : held_arrays()) sum += a.bytes;
    return sum;
  }
  std::vector<KernelCount> kernel_counts() const override {
    std::vector<KernelCount> counts;
    for (const auto& [name, n] : launcher_.launches) counts.push_back({name, n});
    return counts;
  }

 private:
  /// The forces that are in the program. Fewer only to measure that one which is not used costs nothing
  /// (tests/benchmarks).
#ifdef SIMPLEXSEG_BUILT_FORCES
  static constexpr unsigned kBuiltForces = SIMPLEXSEG_BUILT_FORCES;
#else
  static constexpr unsigned kBuiltForces = (1u << kForceCount) - 1;
#endif
  static constexpr bool built(ForceId force) { return (kBuiltForces & bit(force)) != 0; }

  /// Forces hold a mesh that have this share of the multigrid model's k.
  static constexpr float kIsHeld = 1e-3f;

  Executor& executor() { return launcher_.executor; }
  const Executor& executor() const { return launcher_.executor; }
  /// Over all vertices.
  template <class Kernel>
  void run(const Kernel& kernel) {
    launcher_.run(kernel, view_.vertex_count);
  }
  void reset_status() {
    const StepStatus none;
    status_.upload(std::span(&none, 1));
  }

  /// `length` steps, and the end of the batch when something ends. Returns how many were done before a failure that the
  /// host knows of.
  int run_steps(int length, End end) {
    return runs_.run(launcher_, phase_, measured_at_refresh_, refresh_interval_, length, end,
                     [&] { return do_steps(length, end); });
  }
  int do_steps(int length, End end) {
    for (int k = 0; k < length; ++k)
      if (!do_step(k, k == 0 ? length : 0, k + 1 == length ? end : End::None)) return k;
    if (end != End::None) end_batch();
    return length;
  }

  /// False when the step failed and the host knows.
  bool do_step(int of_run, int run_length, End end) {
    update_view();
    const bool refresh = phase_.refresh_due || phase_.since_refresh >= refresh_interval_;
    if (refresh) phase_.since_refresh = 0, phase_.refresh_due = false;
    ++phase_.since_refresh;
    const bool attract = active(ForceId::Attraction);
    const GeometryKernel geometry{view_, run_length, attract && refresh};
    const int n = view_.vertex_count;
    if (!attract)
      run(geometry);
    else if (refresh)
      launcher_.run_together(geometry, n, FindNearest{view_},
                             view_.mesh_count * view_.nearest_blocks * view_.point_groups);
    else
      launcher_.run_together(geometry, n, SumAttraction{view_}, view_.point_count);
    if (refresh) find_targets(attract);
    if (end != End::None) measured_at_refresh_ = refresh;
    if (levels_.held()) {
      if (refresh || phase_.stiffness_due) find_stiffness();
      phase_.stiffness_due = false;
      integrate(of_run, end);
      levels_.cycle(launcher_, view_);
      run(CorrectedStep{view_, of_run, end});
    } else {
      integrate(of_run, end);
    }
    if (executor().failed(status_.data())) return false;
    phase_.oldest = (phase_.oldest + 1) % 3;
    return true;
  }

  void end_batch() {
    update_view();
    launcher_.run(MotionOfBlocks{view_, motion_sums_.data(), motion_blocks()}, static_cast<int>(motion_sums_.size()));
    launcher_.run(EndOfBatch{view_, motion_sums_.data(), motion_blocks(), motion_.data(), result_.data()},
                  view_.mesh_count);
  }

  void apply_parameters(const SimulationParameters& simulation) {
    controls_.resize(constants_.size());
    simulation_ = simulation;
    since_watched_ = 0;
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      MeshConstants& c = constants_[k];
      c.forces = wanted_[k];
      const MeshNeeds needs = mesh_needs(static_cast<int>(k));
      for (const ForceInfo& force : force_list())
        if (!needs.acts(force.id)) c.forces.values[static_cast<int>(force.id)][0] = 0;
      const Stiffness stiffness = stiffness_of(c.forces, references_[k]);
      c.stiffness = stiffness.internal,
      c.model = std::max(0.5f * stiffness.internal, 0.1f * (stiffness.image + stiffness.attraction));
      c.strongest = strongest(c.forces);
      controls_[k].start(simulation, stiffness, learnt_[k], Executor::kCycleCost);
      controls_[k].set_points(c.point_count);
      c.voxel_mm = volume_.empty() ? 1.0f : static_cast<float>(volume_.geometry().spacing_mm.minCoeff());
    }
    refresh_interval_ = static_cast<int>(simulation.refresh_interval + 0.5f);
    keeps_pose_ = simulation.may_grow();
    watched_ = keeps_pose_ || simulation.solver() == Solver::Damped;
    const bool cycles = simulation.solver() == Solver::Automatic || simulation.solver() == Solver::Multigrid;
    for (const SolverControl& control : controls_)
      if (cycles && control.stiffness().internal > 0) levels_.arrange(constants_, neighbours_host_);
    note_limits();
    apply_forms();
    phase_.refresh_due = true;
  }

  /// After a solver has changed how it steps.
  void apply_forms() {
    bool corrected = false;
    for (const SolverControl& control : controls_) corrected = corrected || control.form() == StepForm::Corrected;
    corrected_ = corrected;
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      const float hold = controls_[k].state().hold;
      constants_[k].form = controls_[k].form(), constants_[k].hold = hold > 0 ? hold : SolverControl::kHoldFree;
      hold_known_ = (k == 0 || hold_known_) && (hold > 0 || constants_[k].form != StepForm::Corrected);
    }
    phase_.stiffness_due = true;
    sent_coefficients_.clear();
    hold_what_is_needed();
    for (std::size_t k = 0; k < constants_.size(); ++k) constants_[k].root = levels_.root(k);
    meshes_.assign(constants_);
    update_view();
  }

  bool forms_changed() const {
    for (std::size_t k = 0; k < constants_.size(); ++k)
      if (controls_[k].form() != constants_[k].form) return true;
    return false;
  }

  static int strongest(const ForceParameters& forces) {
    int force = 0;
    for (int f = 1; f < kForceCount; ++f)
      if (forces.values[f][0] > forces.values[force][0]) force = f;
    return force;
  }

  /// How far out a vertex can be and still be in the scene: ten times the size of what is in it, farther than where its
  /// mesh began.
  void note_limits() {
    constexpr double kScenes = 10;
    Eigen::AlignedBox3d scene;
    for (const Eigen::AlignedBox3d& box : box_) scene.extend(box);
    for (const PointView& point : points_host_)
      scene.extend(Eigen::Vector3d(point.position.x, point.position.y, point.position.z));
    if (!volume_.empty())
      for (int corner = 0; corner < 8; ++corner) {
        Eigen::Vector3d index;
        for (int axis = 0; axis < 3; ++axis)
          index[axis] = (corner >> axis & 1) != 0 ? volume_.geometry().size[axis] - 0.5 : -0.5;
        scene.extend(volume_.geometry().world_from_index() * index);
      }
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      const double home = farthest_start(k);
      constants_[k].limit_mm =
          scene.isEmpty() ? 1.0f : static_cast<float>(home + kScenes * scene.diagonal().norm() + 1e-6);
    }
  }

  /// The largest coordinate of the middle of a mesh as it was loaded.
  double farthest_start(std::size_t k) const {
    return box_[k].isEmpty() ? 0.0 : box_[k].center().cwiseAbs().maxCoeff();
  }

  void send_coefficients() {
    coefficients_host_.clear();
    for (const SolverControl& control : controls_) coefficients_host_.push_back(control.coefficients());
    if (coefficients_host_ == sent_coefficients_) return;
    coefficients_.upload(coefficients_host_);
    sent_coefficients_ = coefficients_host_;
  }

  /// Before an interval that may have to be undone.
  void keep_pose() {
    update_view();
    for (std::size_t k = 0; k < constants_.size(); ++k)
      if (folds_.keeps(k))
        launcher_.run(KeepPose{view_.current, kept_.data(), constants_[k].first_vertex}, constants_[k].vertex_count);
  }
  float residual_mm(std::size_t k) {
    float weights = 0;
    for (const ForceInfo& force : force_list())
      weights += active(force.id) ? constants_[k].forces.weight(force.id) : 0.0f;
    return weights > 0 ? std::sqrt(std::max(motion_.data()[k].mean_square_force, 0.0f)) / weights : 0.0f;
  }
  /// At the end of an interval.
  void learn(StepOutcome& outcome) {
    folds_.note(constants_, motion_.data());
    for (std::size_t k = 0; k < constants_.size() && !outcome.failure; ++k) {
      if (kept_.size() != 0 && folds_.crumpled(k, residual_mm(k), motion_.data()[k], constants_[k].edge_mm)) {
        undo({static_cast<int>(k), -1, static_cast<ForceId>(constants_[k].strongest), StepFailure::What::Folded},
             outcome);
        continue;
      }
      // Targets that were found anew say nothing of stiffness, unless they always are.
      if (measured_at_refresh_ && refresh_interval_ > 1) continue;
      const MeshMotion& motion = motion_.data()[k];
      // Below the digits of a position, and below what an edge is, motion is rounding.
      const MeshConstants& c = constants_[k];
      const float farthest = static_cast<float>(farthest_start(k)) + motion.mean_edge_mm;
      const float noise = std::max(1e-4f * motion.mean_edge_mm, 1e-6f * farthest);
      if (controls_[k].learn(motion.change, motion.square_move, noise) && !measured_at_refresh_) {
        undo({static_cast<int>(k), -1, static_cast<ForceId>(c.strongest), StepFailure::What::Grew}, outcome);
      }
    }
    if (forms_changed())
      apply_forms();
    else if (corrected_)
      note_hold();
  }

  /// Puts the mesh back to the pose that was kept, or to the last good one, at rest, and halves its timestep.
  void undo(const StepFailure& failure, StepOutcome& outcome) {
    const MeshConstants& c = constants_[failure.mesh];
    update_view();
    const int now = (phase_.oldest + 1) % 3;
    const Vec4* good = kept_.size() != 0 ? kept_.data() : positions_[now].data();
    launcher_.run(RestorePose{good, positions_[now].data(), positions_[phase_.oldest].data(), c.first_vertex},
                  c.vertex_count);
    executor().wait();
    if (attraction_.size() != 0) attraction_.fill_zero();
    phase_.refresh_due = true;
    since_watched_ = 0;
    watched_ = true;
    folds_.put_back(failure.mesh);
    if (controls_[failure.mesh].cut())
      outcome.cuts.push_back({failure, controls_[failure.mesh].cut_factor()});
    else
      outcome.failure = failure;
  }

  /// Whether forces hold each mesh.
  void note_hold() {
    bool anew = false;
    for (std::size_t k = 0; k < constants_.size(); ++k) {
      MeshConstants& c = constants_[k];
      if (c.form != StepForm::Corrected) continue;
      controls_[k].set_held(motion_.data()[k].hold > kIsHeld * c.model);
      anew = anew || controls_[k].state().hold != c.hold;
      c.hold = controls_[k].state().hold;
    }
    hold_known_ = true;
    if (forms_changed()) return apply_forms();
    if (anew) meshes_.upload(constants_), phase_.stiffness_due = true;
  }

  void find_stiffness() {
    stiffness_by_mask();
    levels_.sum_stiffness(launcher_, view_);
  }
  template <unsigned kMask = 0>
  void stiffness_by_mask() {
    if constexpr (kMask < 1u << kForceCount) {
      // Internal forces are in the model as a whole.
      constexpr unsigned kInternal = bit(ForceId::Smoothing) | bit(ForceId::ShapeMemory);
      if constexpr ((kMask & kInternal) != 0 || (kMask & ~kBuiltForces) != 0)
        stiffness_by_mask<kMask + 1>();
      else if (kMask == (needs_.forces & ~kInternal))
        run(LocalStiffness<kMask>{view_});
      else
        stiffness_by_mask<kMask + 1>();
    }
  }

  MeshNeeds mesh_needs(int k) const {
    const MeshConstants& c = constants_[k];
    MeshNeeds needs{c.forces, c.vertex_count, c.finest != 0, !references_[k].empty(), profiles_host_[k].size()};
    if (!held_targets_.empty())
      for (const ForceInfo& force : force_list())
        if (!held_targets_[k][static_cast<int>(force.id)].empty()) needs.held |= bit(force.id);
    return needs;
  }
  bool active(ForceId force) const { return (kBuiltForces & bit(force)) != 0 && needs_.uses(force); }
  /// Null for a force without targets.
  Array<Vec4>* target_array(ForceId force) {
    return force == ForceId::Gradient           ? &gradient_target_
           : force == ForceId::IntensityProfile ? &profile_target_
           : force == ForceId::Region           ? &region_target_
                                                : nullptr;
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
            std::copy_n(profiles_host_[k].begin() + orders_[k][i] * length, length,
                        all.begin() + (c.first_vertex + i) * stride);
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
    if (corrected_ && n > 0)
      levels_.hold(constants_, neighbours_host_);
    else
      levels_.drop();
    hold(kept_, keeps_pose_, n);
    if (coefficients_.size() != constants_.size()) coefficients_.resize(constants_.size()), sent_coefficients_.clear();
    // What earlier bindings left in the sums would go on pulling.
    if (attract) attraction_.fill_zero();
    update_view();
    recorded_interval_ = refresh_interval_;
    // Recorded runs hold the addresses and the plan.
    if (!(needed_before == needs_) || interval_before != refresh_interval_ || !same_addresses(view_before, view_))
      runs_.clear();
  }

  static bool same_addresses(StepView a, StepView b) {
    // The three position arrays take turns.
    a.previous = b.previous, a.current = b.current, a.next = b.next, a.oldest = b.oldest;
    static_assert(std::is_trivially_copyable_v<StepView>);
    return std::memcmp(&a, &b, sizeof a) == 0;
  }

  void update_view() {
    view_.meshes = meshes_.data(), view_.neighbours = neighbours_.texels();
    view_.previous = positions_[phase_.oldest].texels(), view_.current = positions_[(phase_.oldest + 1) % 3].texels();
    view_.next = positions_[(phase_.oldest + 2) % 3].data(), view_.oldest = positions_[phase_.oldest].data(),
    view_.frame = frame_.texels(), view_.new_frame = frame_.data();
    view_.shape = shape_.texels();
    view_.gradient_target = gradient_target_.data(), view_.profile_target = profile_target_.data();
    view_.region_target = region_target_.data(), view_.profiles = profiles_.data();
    view_.region_tables = region_tables_.data(), view_.local_statistics = local_statistics_.data();
    view_.points = points_.data(), view_.nearest = nearest_.data(), view_.patches = patches_.data();
    view_.attraction = attraction_.data(), view_.attracted = attracted_.data(), view_.status = status_.data();
    view_.coefficients = coefficients_.data();
    view_.levels = levels_.view();
  }

  /// `bind`: attraction patches too, beside the first search.
  void find_targets(bool bind) {
    auto search = [&](const auto& kernel) {
      if (bind)
        launcher_.run_together(kernel, view_.vertex_count, BindPatch{view_}, view_.point_count);
      else
        run(kernel);
      bind = false;
    };
    if (needs_.searches())
      executor().visit_voxels(volume_.type(), [&]<class Voxels>(std::type_identity<Voxels>) {
        executor().visit_width(view_.vertex_count, [&]<int kWidth>(std::integral_constant<int, kWidth>) {
          if constexpr (built(ForceId::Gradient))
            if (needs_.searches(ForceId::Gradient))
              search(GradientSearch<Voxels, kWidth>{view_, kWidth > 1 ? needs_.gradient_scratch : 0});
          if constexpr (built(ForceId::IntensityProfile))
            if (needs_.searches(ForceId::IntensityProfile))
              search(ProfileSearch<Voxels, kWidth>{view_, needs_.profile_scratch});
          if constexpr (built(ForceId::Region)) {
            if (!needs_.searches(ForceId::Region)) return;
            if (local_statistics_.size() != 0) {
              using Statistics = RegionStatistics<Voxels, kWidth>;
              search(Statistics{view_, Statistics::kCount});
              average(local_statistics_.data(), kStatisticsPasses, false);
              static_assert(kStatisticsPasses % 2 == 0, "so that the averages end where they are read");
            }
            search(RegionSearch<Voxels, kWidth>{view_, needs_.region_scratch});
            run(RegionTarget{view_, average(region_target_.data(), needs_.averaging_passes, true)});
          }
        });
      });
    if (bind) launcher_.run(BindPatch{view_}, view_.point_count);
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
  void integrate(int step, End end) {
    if constexpr (kMask < 1u << kForceCount) {
      if constexpr ((kMask & ~kBuiltForces) != 0)
        integrate<kMask + 1>(step, end);
      else if (kMask != needs_.forces)
        integrate<kMask + 1>(step, end);
      else if (levels_.held())
        run(IntegrateKernel<kMask, true>{view_, step, end});
      else
        run(IntegrateKernel<kMask, false>{view_, step, end});
    }
  }

  int largest_mesh() const {
    int largest = 0;
    for (const MeshConstants& c : constants_) largest = std::max(largest, c.vertex_count);
    return largest;
  }
  int motion_blocks() const { return (largest_mesh() + MotionOfBlocks::kBlock - 1) / MotionOfBlocks::kBlock; }

  Launcher<Executor> launcher_;  // first: arrays go before the device they live on
  Volume volume_;
  StepView view_;
  std::vector<MeshConstants> constants_;
  std::vector<std::vector<int>> orders_;  ///< of each mesh: the vertex, as it was loaded, at each place
  std::vector<std::vector<Vec4>> references_;
  std::vector<std::array<std::vector<Vec4>, kForceCount>>
      held_targets_;  ///< of each mesh and force; empty: none at all
  std::vector<std::vector<float>> profiles_host_;
  std::vector<Vec4> shape_host_;
  std::vector<float> region_tables_host_;
  std::vector<PointView> points_host_;
  StepNeeds needs_;
  int refresh_interval_ = 1, recorded_interval_ = 0;
  StepPhase phase_;

  Array<MeshConstants> meshes_;
  typename Executor::NeighbourArray neighbours_;
  std::vector<SolverControl> controls_;
  std::vector<SolverState> learnt_;
  std::vector<ForceParameters> wanted_;
  std::vector<Eigen::AlignedBox3d> box_;  ///< of each mesh as it was loaded
  std::vector<Int4> neighbours_host_;
  FoldWatch folds_;
  bool hold_known_ = false;
  bool watched_ = false;  ///< every interval of steps is looked at
  bool keeps_pose_ = false, corrected_ = false, measured_at_refresh_ = false;
  int since_watched_ = 0;
  SimulationParameters simulation_{};
  std::vector<StepCoefficients> coefficients_host_, sent_coefficients_;
  CoarseLevels<Executor> levels_;
  Array<StepCoefficients> coefficients_;
  Array<Vec4> positions_[3], kept_, frame_, shape_, gradient_target_, profile_target_, region_target_,
      local_statistics_, scratch_;
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
  SurfaceDrawing<Executor> drawing_;
  RecordedRuns<Executor> runs_;
};

}  // namespace simplexseg
