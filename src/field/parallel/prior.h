// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "field/coarse_image.h"
#include "field/conductances.h"
#include "field/field_solver.h"
#include "field/find_value.h"
#include "field/parallel/appearance.h"
#include "field/parallel/blocks.h"
#include "field/parallel/distance.h"
#include "field/parallel/geodesic.h"
#include "field/parallel/inner_difference.h"
#include "field/parallel/network.h"
#include "field/parallel/prior_kernels.h"
#include "field/parallel/walker.h"
#include "field/stroke.h"
#include "field/update_progress.h"

namespace simplexseg {

/// Prompts and constraints in the memory of an executor.
struct DevicePrompts {
  std::span<const Mark> marks;
  const Constraint* constraints;  ///< a value for each cell of the box
  const std::uint8_t* previous;   ///< previous field, 1..255 for 0..1, 0: unknown; null without one
  std::span<const NewMarkBall> new_balls;
  double scale_mm, radius_mm;
  const ShapePrior* shape = nullptr;  ///< null: none
};

/// Prior of the field: foreground probability on blocks of cells. The width of blocks increases with the object scale,
/// so that features do not depend on the size of the object, noise is averaged, and large objects take no longer.
/// Features of the images are computed by the CPU, once for a box; features of marks by the executor, except for the
/// solution of the equations of the classifier and medians within the marks. Source: docs/mathematics.md 8.4.
template <class Executor>
class ParallelPrior {
 public:
  /// `run`: threads of the CPU. The executor must outlive the prior.
  ParallelPrior(const Executor& executor, const EvidenceSettings& settings, RunJobs run)
      : executor_(executor),
        settings_(settings),
        run_(std::move(run)),
        marks_network_(executor, networks_of(settings).marks),
        update_network_(executor, networks_of(settings).update),
        painted_(executor) {}

  /// Sets the image of a box of cells whose first cell is `first`, for an object of this scale. `cells`: grid of all
  /// cells of the volume; `further`: further images, as many in each call.
  void set_box(const BoxImage& image, const VolumeGeometry& cells, const std::array<int, 3>& first, double scale_mm,
               std::span<const BoxImage> further = {}) {
    coarse_ = coarse_image(cells, image, first, scale_mm, settings_, run_, further);
    const std::size_t n = blocks();
    if (!appearance_) appearance_.emplace(executor_, static_cast<int>(coarse_.features.size()));
    image_ = executor_.template copy_of<float>(coarse_.smoothed);
    features_ = executor_.template array<float>(n * coarse_.features.size());
    for (std::size_t f = 0; f < coarse_.features.size(); ++f)
      executor_.template upload<float>(coarse_.features[f], features_.data() + f * n);
    for (std::size_t f = 0; f < coarse_.features.size(); ++f)
      if (!needed_on_host(f)) coarse_.features[f] = {};
    random_walk_ = executor_.template array<float>(n);
    executor_.clear(random_walk_.data(), n);
    release_workspace();
  }

  /// Computes the prior of all blocks. `progress`: receives the end of FieldPhase::CoarsePrior; may be null.
  void compute(const DevicePrompts& prompts, UpdateProgress* progress = nullptr) {
    allocate_workspace();
    const bool uses_previous = !prompts.new_balls.empty() && settings_.memory;
    find_constraints(prompts);
    MarkView view = view_of(prompts);
    find_nearest(prompts, uses_previous, view);
    const AppearanceSamples samples = appearance_samples(host_constraints_, settings_);
    const bool uses_appearance = settings_.use_appearance && !samples.inside.empty() && !samples.outside.empty();
    if (uses_appearance) appearance_->begin(features_.data(), blocks(), samples);
    view.noise = noise_of(inner_difference_);
    if (uses_previous) measure_inward();
    score_appearance(uses_appearance);
    executor_.each(blocks(), OutsideSources{constraints_.data(), open_, outside_, edges_out_});
    begin_geodesic(uses_previous, view.noise);
    if (settings_.use_random_walk) solve_random_walk(sharpness_of(inner_difference_, settings_));
    set_z_scores(view);  // while the executor works
    const auto shell = fetch_counts(BinOfShell{view});
    geodesic_->finish();
    view.shell_contrast = median_of_shell(received_counts(shell));
    if (progress) progress->advance(FieldPhase::CoarsePrior);
    if (records_) record(view, recorded_.marks);
    executor_.each_lanes(blocks(), OutputOfNetwork<MarkView>{view, marks_network_.view(), prior_});
    if (uses_previous) {
      const UpdateView update = update_view(prompts.scale_mm, view.marks);
      if (records_) record_update(update);
      executor_.each_lanes(blocks(), PriorAfterUpdate{update, update_network_.view(), prior_});
    } else if (settings_.expected_dice_threshold) {
      apply_expected_dice_threshold();
    }
    if (prompts.shape) {
      shape_log_odds_ = executor_.template copy_of<float>(prompts.shape->at_cells(coarse_.geometry, run_));
      executor_.each(blocks(), AddLogOdds{shape_log_odds_.data(), prior_});
    }
  }

  /// FieldSolver::record_features()
  void record_features(bool record) { records_ = record; }
  const PriorFeatures& features() const { return recorded_; }

  /// Writes the prior of each cell of the box, 0..255 for 0..1, by joint bilateral upsampling: linear interpolation
  /// between the centres of blocks with larger weights for blocks of similar intensity. `smoothed`: smoothed image of
  /// the cells; `edge`: difference with half of the weight. Source: Kopf et al. 2007, Joint Bilateral Upsampling.
  void interpolate(const float* smoothed, float edge, std::uint8_t* voxels) const {
    const VoxelBlocks& b = coarse_.blocks;
    if (b.width == std::array{1, 1, 1})
      executor_.copy(static_cast<const std::uint8_t*>(prior_), voxels, blocks());
    else
      executor_.each_cell(
          b.fine, InterpolateBlocks{b.fine, b.coarse, b.width, prior_, image_.data(), smoothed, 1 / edge, voxels});
  }
  /// Writes 1 for cells of the sides of the box that may belong to the object (is_open()), else 0.
  void mark_open(const Constraint* constraints, std::uint8_t* open) const {
    const VoxelBlocks& b = coarse_.blocks;
    executor_.each_cell(b.fine, OpenVoxel{b.fine, b.coarse, b.width, constraints, open_, open});
  }
  /// Releases the prior and the workspace of an update.
  void release_workspace() {
    all_floats_ = {};
    all_bytes_ = {};
    constraints_ = {};
    nearest_ = {};
    nearest_new_ = {};
    counts_ = {};
    shape_log_odds_ = {};
    combined_ = {};
    geodesic_.reset();
    walker_.reset();
    if (appearance_) appearance_->release_workspace();
  }
  /// Memory of the executor and of the host, bytes.
  std::size_t bytes() const {
    std::size_t bytes = marks_network_.bytes() + update_network_.bytes() + painted_.bytes() + balls_.bytes() +
                        places_.bytes() + new_balls_.bytes() + shape_log_odds_.bytes() + combined_.bytes() +
                        z_scores_.bytes() + image_.bytes() + features_.bytes() + constraints_.bytes() +
                        nearest_.bytes() + nearest_new_.bytes() + counts_.bytes() + host_constraints_.size();
    bytes += all_floats_.bytes() + all_bytes_.bytes();
    bytes += coarse_.smoothed.size() * sizeof(float);
    for (const std::vector<float>& feature : coarse_.features) bytes += feature.size() * sizeof(float);
    if (appearance_) bytes += appearance_->bytes();
    if (walker_) bytes += walker_->bytes() + geodesic_->bytes();
    return bytes + random_walk_.bytes();
  }

 private:
  using Floats = typename Executor::template Array<float>;
  using Bytes = typename Executor::template Array<std::uint8_t>;

  static const PriorNetworks& networks_of(const EvidenceSettings& settings) {
    return settings.networks ? *settings.networks : learned_networks();
  }
  const BoxGrid& grid() const { return coarse_.blocks.coarse; }
  int blocks() const { return grid().count(); }
  /// Lists with a value for each block, for an update.
  std::array<float**, 12> float_lists() {
    return {&score_,    &from_inside_, &from_outside_, &new_square_,   &inside_,     &outside_,
            &edges_in_, &edges_out_,   &inward_,       &edges_to_new_, &squares_[0], &squares_[1]};
  }
  std::array<std::uint8_t**, 6> byte_lists() {
    return {&previous_, &previous_object_, &open_, &fixed_, &finite_, &prior_};
  }
  /// Allocates one array for all lists and sets their pointers.
  template <class T, std::size_t kCount>
  typename Executor::template Array<T> allocate_lists(const std::array<T**, kCount>& lists) const {
    auto all = executor_.template array<T>(kCount * blocks());
    for (std::size_t l = 0; l < kCount; ++l) *lists[l] = all.data() + l * blocks();
    return all;
  }

  void allocate_workspace() {
    if (walker_) return;
    const std::size_t n = blocks();
    all_floats_ = allocate_lists(float_lists());
    all_bytes_ = allocate_lists(byte_lists());
    constraints_ = executor_.template array<Constraint>(n);
    nearest_ = executor_.template array<std::uint16_t>(n);
    nearest_new_ = executor_.template array<std::uint16_t>(n);
    counts_ = executor_.template array<int>(kBins);
    geodesic_.emplace(executor_, grid(), coarse_.spacing_mm, image_.data());
    walker_ = std::make_unique<ParallelWalker<Executor>>(grid(), coarse_.spacing_mm, executor_);
    executor_.copy(static_cast<const float*>(random_walk_.data()), walker_->field(), n);  // start of the solution
  }

  void find_constraints(const DevicePrompts& prompts) {
    const PaintedBalls marks = painted_.upload(coarse_.geometry, VoxelBox{{0, 0, 0}, grid().size}, prompts.marks);
    const VoxelBlocks& b = coarse_.blocks;
    executor_.each_cell(grid(), ConstraintOfBlock{b.fine, b.coarse, b.width, marks, prompts.constraints,
                                                  prompts.previous, constraints_.data(), previous_});
    const VoxelBox box{{0, 0, 0}, grid().size};
    const auto difference =
        fetch_inner_difference(executor_, grid(), coarse_.spacing_mm, image_.data(), constraints_.data(),
                               box_around_inside(painted_balls(coarse_.geometry, box, prompts.marks)));
    host_constraints_.resize(blocks());
    executor_.download(constraints_.data(), std::span<Constraint>(host_constraints_));
    inner_difference_ = received_inner_difference(executor_, difference);
  }
  /// Whether z_score_of_marks(), of an image relative to the inside marks, needs a feature: of the main one only two.
  static constexpr bool needed_on_host(std::size_t feature) { return feature > 0 && feature % kVoxelFeatures < 3; }
  IntensityZScore z_score_of_marks(int image) const {
    std::array<std::vector<float>, 3> values;
    const int n = blocks();
    const auto next_inside = [&](int from) { return find_value(host_constraints_, Constraint::Inside, from, n); };
    for (int v = next_inside(0); v < n; v = next_inside(v + 1)) {
      for (int l = 0; l < 3; ++l)
        values[l].push_back(
            (image == 0 && l == 0 ? coarse_.smoothed : coarse_.features[kVoxelFeatures * image + l])[v]);
    }
    return fit_z_score(values);
  }

  /// Sets the z-scores of a view; those of several images are combined.
  void set_z_scores(MarkView& view) {
    view.z_score = z_score_of_marks(0);
    view.inverse_deviation = view.z_score.inverse_deviation[0];
    const int images = coarse_.images();
    if (images == 1) return;
    std::vector<IntensityZScore> all{view.z_score};
    for (int n = 1; n < images; ++n) all.push_back(z_score_of_marks(n));
    combined_ = executor_.template array<float>(3 * std::size_t(blocks()));
    executor_.each(blocks(), CombineZScores{image_.data(), features_.data(), z_scores_.set(executor_, all), images,
                                            blocks(), combined_.data()});
    view.z_score = {};
    view.image = combined_.data();
    for (int s = 1; s < 3; ++s) view.smoothed[s - 1] = combined_.data() + std::size_t(s) * blocks();
  }

  MarkView view_of(const DevicePrompts& prompts) {
    const std::vector<MarkedBall> balls = marked_balls(prompts.marks, coarse_.geometry);
    MarkView view{};
    view.grid = grid();
    view.constraints = constraints_.data();
    view.image = image_.data();
    for (int s = 1; s < 3; ++s) view.smoothed[s - 1] = features_.data() + std::size_t(s) * blocks();
    view.score = score_;
    view.walker = walker_->field();
    view.inside = inside_, view.outside = outside_;
    view.edges_in = edges_in_, view.edges_out = edges_out_;
    view.from_inside = from_inside_, view.from_outside = from_outside_;
    view.nearest = nearest_.data();
    view.balls = balls_.set(executor_, balls);
    view.scale_mm = static_cast<float>(prompts.scale_mm), view.radius_mm = static_cast<float>(prompts.radius_mm);
    view.least_spacing_mm = least_spacing_mm();
    view.ball_count = static_cast<int>(balls.size());
    view.marks = prompt_ball_count(prompts.marks);
    view.use_geodesic = settings_.use_geodesic, view.use_random_walk = settings_.use_random_walk;
    return view;
  }
  float least_spacing_mm() const {
    return static_cast<float>(*std::min_element(coarse_.spacing_mm.begin(), coarse_.spacing_mm.end()));
  }

  void find_nearest(const DevicePrompts& prompts, bool uses_previous, const MarkView& view) {
    const Eigen::Affine3d index = coarse_.geometry.index_from_world(), world = coarse_.geometry.world_from_index();
    const auto place = [&](const Eigen::Vector3d& mm) {
      const Eigen::Vector3f at = (index * mm).cast<float>();
      return IndexPlace{{at[0], at[1], at[2]}};
    };
    NearestMarks nearest{};
    nearest.grid = grid(), nearest.constraints = constraints_.data();
    nearest.balls = view.balls, nearest.ball_count = view.ball_count;
    nearest.from_inside = from_inside_, nearest.from_outside = from_outside_, nearest.nearest = nearest_.data();
    nearest.new_square = new_square_, nearest.nearest_new = nearest_new_.data();
    nearest.to_inside = inside_, nearest.edges_in = edges_in_, nearest.edges_to_new = edges_to_new_;
    for (int a = 0; a < 3; ++a) {
      nearest.spacing_mm[a] = static_cast<float>(coarse_.spacing_mm[a]);
      for (int b = 0; b < 3; ++b) nearest.square_mm.mm[a][b] = static_cast<float>(world.linear()(a, b));
    }
    std::vector<IndexPlace> places;
    for (const Mark& mark : prompts.marks)
      if (mark.kind != MarkKind::Outside) places.push_back(place(mark.position_mm));
    nearest.inside_count = static_cast<int>(places.size());
    std::vector<NewMarkVoxel> new_balls;
    if (uses_previous)
      for (const NewMarkBall& ball : prompts.new_balls) {
        places.push_back(place(ball.centre_mm));
        const int voxel = nearest_block(places.back(), nearest.square_mm);
        new_balls.push_back({static_cast<float>(ball.radius_mm), coarse_.smoothed[voxel],
                             static_cast<float>(ball.depth_mm), voxel, ball.inside});
      }
    nearest.new_count = static_cast<int>(new_balls.size());
    nearest.inside = places_.set(executor_, places);
    nearest.new_centres = nearest.inside + nearest.inside_count;
    nearest.new_balls = device_new_balls_ = new_balls_.set(executor_, new_balls);
    executor_.each_cell(grid(), nearest);
  }
  /// Nearest block to a place; the first of several.
  int nearest_block(const IndexPlace& place, const SquareInMm& square_mm) const {
    std::array<int, 3> low, high;
    for (int a = 0; a < 3; ++a) {
      const int last = grid().size[a] - 1, at = static_cast<int>(std::floor(place.index[a]));
      low[a] = std::clamp(at - 1, 0, last), high[a] = std::clamp(at + 2, 0, last);
    }
    int found = 0;
    float least = 2 * kFarSquare;
    for (int k = low[2]; k <= high[2]; ++k)
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) {
          const int v = (k * grid().size[1] + j) * grid().size[0] + i;
          const float square = square_mm(cell_at(grid(), v), place);
          if (square < least) least = square, found = v;
        }
    return found;
  }

  using FetchedCounts = typename Executor::template Fetched<int>;
  template <class Bin>
  FetchedCounts fetch_counts(const Bin& bin) {
    executor_.clear(counts_.data(), kBins);
    executor_.histogram(blocks(), bin, counts_.data());
    return executor_.fetch(counts_.data(), kBins);
  }
  std::vector<int> received_counts(const FetchedCounts& fetched) const {
    std::vector<int> counts(kBins);
    executor_.receive(fetched, std::span<int>(counts));
    return counts;
  }
  static float median_of_shell(const std::vector<int>& counts) {
    long rank = 0;
    for (const int count : counts) rank += count;
    if (rank == 0) return 0;
    rank = (rank - 1) / 2;
    int bin = 0;
    while (rank >= counts[bin]) rank -= counts[bin++];
    const float at = bin + 1 == kBins ? static_cast<float>(bin) : static_cast<float>(bin) + 0.5f;
    return at * (IntensityZScore::kMost / (kBins - 1));
  }

  void begin_geodesic(bool uses_previous, float noise) {
    const EdgeCost changes = cost_of_changes(settings_), edges = cost_of_edges(noise);
    const std::array<typename ParallelGeodesic<Executor>::Distance, kMostDistances> distances{
        {{inside_, changes}, {edges_in_, edges}, {outside_, changes}, {edges_out_, edges}, {edges_to_new_, edges}}};
    geodesic_->begin(std::span(distances).first(uses_previous ? 5 : 4));
  }
  void measure_inward() {
    constexpr float everywhere_mm = 1e18f;
    executor_.each(blocks(), PreviousObject{previous_, previous_object_});
    squared_distance_to_other_side(executor_, previous_object_, grid(), coarse_.spacing_mm, everywhere_mm, true,
                                   squares_[0], squares_[1]);
    executor_.each(blocks(), Inward{previous_object_, squares_[0], least_spacing_mm(), inward_});
  }

  void score_appearance(bool uses_appearance) {
    if (uses_appearance) {
      appearance_->score(constraints_.data(), static_cast<float>(settings_.open_side), score_, open_);
    } else {
      executor_.clear(score_, blocks());
      executor_.clear(open_, blocks());
    }
  }

  void solve_random_walk(double sharpness) {
    executor_.each(blocks(), RandomWalkConstraints{constraints_.data(), open_, fixed_, finite_, walker_->field()});
    executor_.clear(prior_, blocks());  // has no weight
    set_edges(executor_, *walker_, coarse_.spacing_mm, image_.data(), finite_, sharpness, 0);
    walker_->solve(prior_, fixed_, kWalkerTolerance, settings_.most_iterations);
    executor_.copy(static_cast<const float*>(walker_->field()), random_walk_.data(), random_walk_.size());
  }

  UpdateView update_view(double scale_mm, int marks) const {
    UpdateView view{};
    view.image = image_.data(), view.previous = previous_, view.prior_of_marks = prior_;
    view.balls = device_new_balls_, view.nearest = nearest_new_.data();
    view.square = new_square_, view.edges = edges_to_new_, view.inward = inward_;
    view.per_scale = static_cast<float>(1 / scale_mm), view.least_spacing_mm = least_spacing_mm();
    view.per_noise = 1 / cost_of_edges(noise_of(inner_difference_)).edge;
    view.marks = static_cast<float>(marks);
    view.far_memory = static_cast<float>(settings_.far_memory);
    view.far_depths = static_cast<float>(settings_.far_depths);
    return view;
  }

  /// Copies the features of all blocks to the host.
  template <class View>
  void record(const View& view, std::vector<std::vector<float>>& to) {
    const auto all = executor_.template array<float>(std::size_t(View::kFeatures) * blocks());
    executor_.each(blocks(), RecordedFeatures<View>{view, all.data(), blocks()});
    to.assign(View::kFeatures, std::vector<float>(blocks()));
    for (int f = 0; f < View::kFeatures; ++f)
      executor_.download(all.data() + std::size_t(f) * blocks(), std::span<float>(to[f]));
    recorded_.size = grid().size;
    recorded_.constraints = host_constraints_;
    recorded_.update.clear();
    recorded_.near_inside.clear();
  }
  void record_update(const UpdateView& view) {
    std::vector<std::vector<float>> update;
    record(view, update);
    recorded_.update = std::move(update);
    const auto inside = executor_.template array<std::uint8_t>(blocks());
    executor_.each(blocks(), NearestIsInside{view, inside.data()});
    recorded_.near_inside.resize(blocks());
    executor_.download(inside.data(), std::span<std::uint8_t>(recorded_.near_inside));
  }

  void apply_expected_dice_threshold() {
    const std::vector<int> counts = received_counts(fetch_counts(BinOfThreshold{constraints_.data(), prior_}));
    executor_.each(blocks(),
                   ScaleOdds{expected_dice_odds_factor(std::span<const int, 256>(counts.data(), 256)), prior_});
  }

  const Executor& executor_;
  EvidenceSettings settings_;
  RunJobs run_;
  ParallelNetwork<Executor> marks_network_, update_network_;
  ConstraintMask<Executor> painted_;
  UploadedList<Executor, MarkedBall> balls_;
  UploadedList<Executor, IndexPlace> places_;
  UploadedList<Executor, NewMarkVoxel> new_balls_;
  UploadedList<Executor, IntensityZScore> z_scores_;
  const NewMarkVoxel* device_new_balls_ = nullptr;

  bool records_ = false;
  PriorFeatures recorded_;
  CoarseImage coarse_;
  float inner_difference_ = 0;
  std::vector<Constraint> host_constraints_;
  // A value for each block of the present box.
  Floats image_, features_;  ///< `features_`: features x blocks
  Floats shape_log_odds_;    ///< of ShapePrior
  Floats combined_;          ///< CombineZScores; empty with one image
  Floats random_walk_;       ///< solution of the random walker of the marks alone
  // A value for each block, for an update.
  typename Executor::template Array<Constraint> constraints_;
  Floats all_floats_;
  Bytes all_bytes_;
  typename Executor::template Array<std::uint16_t> nearest_, nearest_new_;
  std::uint8_t *previous_{}, *previous_object_{}, *open_{}, *fixed_{}, *finite_{}, *prior_{};
  float *score_{}, *from_inside_{}, *from_outside_{}, *new_square_{};
  float *inside_{}, *outside_{}, *edges_in_{}, *edges_out_{}, *edges_to_new_{}, *inward_{};
  std::array<float*, 2> squares_{};

  typename Executor::template Array<int> counts_;
  std::optional<ParallelAppearance<Executor>> appearance_;
  std::unique_ptr<ParallelWalker<Executor>> walker_;
  std::optional<ParallelGeodesic<Executor>> geodesic_;
};

}  // namespace simplexseg
