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
#include "field/update_progress.h"

namespace simplexseg {

/// Prompts and constraints in the memory of an executor.
struct DevicePrompts {
  std::span<const Mark> marks;
  const Constraint* known;     ///< voxels of the box
  const std::uint8_t* before;  ///< field before the new dots, 1..255 for 0..1, 0: not known; null without new dots
  std::span<const NewMarkBall> fresh;
  double reach_mm, radius_mm;
};

/// The prior of the field, P(object), on blocks of cells: the wider, the larger the object is, so that objects of any
/// size look alike, noise is averaged, and a large object takes no longer than a small one. Features of the image alone
/// are computed by the CPU, once for a box; features of marks by the executor, except for the solution of the
/// classifier's equations and medians within the marks. The bits of an executor are reproducible.
template <class Executor>
class ParallelPrior {
 public:
  /// `run`: runs the part of the CPU. `executor` must outlive it.
  ParallelPrior(const Executor& executor, const EvidenceSettings& settings, RunJobs run)
      : executor_(executor),
        settings_(settings),
        run_(std::move(run)),
        marks_network_(executor, networks_of(settings).marks),
        update_network_(executor, networks_of(settings).update),
        painted_(executor) {}

  /// Sets the image of a box of cells whose first cell is `first`, for an object of this scale. `cells`: grid of all
  /// cells of the volume.
  void set_box(const BoxImage& image, const VolumeGeometry& cells, const std::array<int, 3>& first, double reach_mm) {
    coarse_ = coarse_image(cells, image, first, reach_mm, settings_, run_);
    const std::size_t n = blocks();
    if (!looks_) looks_.emplace(executor_, static_cast<int>(coarse_.features.size()));
    image_ = executor_.template copy_of<float>(coarse_.smoothed);
    features_ = executor_.template array<float>(n * coarse_.features.size());
    for (std::size_t f = 0; f < coarse_.features.size(); ++f)
      executor_.template upload<float>(coarse_.features[f], features_.data() + f * n);
    for (std::size_t f = 0; f < coarse_.features.size(); ++f)
      if (!hears_within_marks(f)) coarse_.features[f] = {};
    walk_ = executor_.template array<float>(n);
    executor_.clear(walk_.data(), n);
    put_work_away();
  }

  /// Computes the prior of all blocks. `progress`: receives the end of FieldPhase::CoarsePrior; or null.
  void learn(const DevicePrompts& said, UpdateProgress* progress = nullptr) {
    take_work_out();
    const bool remembers = !said.fresh.empty() && settings_.memory;
    find_known(said);
    MarkView view = view_of(said);
    find_nearest(said, remembers, view);
    const LookSamples samples = look_samples(known_on_host_, settings_);
    const bool hears_looks = settings_.use_appearance && !samples.inside.empty() && !samples.outside.empty();
    if (hears_looks) looks_->begin(features_.data(), blocks(), samples);
    view.noise = noise_of(inner_difference_);
    if (remembers) measure_inward();
    score_looks(hears_looks);
    executor_.each(blocks(), StartOutside{known_.data(), open_, outside_, edges_out_});
    begin_ways(remembers, view.noise);
    if (settings_.use_random_walk) walk(sharpness_of(inner_difference_, settings_));
    view.strangeness = strangeness_in_marks();  // while the executor works
    const auto shell = fetch_counts(BinOfShell{view});
    ways_->finish();
    view.wall = median_of_shell(received_counts(shell));
    if (progress) progress->advance(FieldPhase::CoarsePrior);
    if (records_) record(view, recorded_.marks);
    executor_.each_lanes(blocks(), OutputOfNetwork<MarkView>{view, marks_network_.view(), prior_});
    if (remembers) {
      const UpdateView update = update_view(said);
      if (records_) record_update(update);
      executor_.each_lanes(blocks(), PriorAfterUpdate{update, update_network_.view(), prior_});
    } else if (settings_.expected_dice_threshold) {
      move_to_best_cut();
    }
  }

  /// FieldSolver::record_features()
  void record_features(bool record) { records_ = record; }
  const PriorFeatures& features() const { return recorded_; }

  /// Writes P(object), 0..255 for 0..1, of each cell of the box. `smoothed`: smoothed image of the cells; `edge`: a
  /// difference in it that is an edge. Linear between the centres of blocks; blocks that resemble the cell have more
  /// weight, so that edges are preserved (joint bilateral upsampling, Kopf et al. 2007).
  void interpolate(const float* smoothed, float edge, std::uint8_t* voxels) const {
    const VoxelBlocks& b = coarse_.blocks;
    if (b.width == std::array{1, 1, 1})
      executor_.copy(static_cast<const std::uint8_t*>(prior_), voxels, blocks());
    else
      executor_.each_cell(
          b.fine, InterpolateBlocks{b.fine, b.coarse, b.width, prior_, image_.data(), smoothed, 1 / edge, voxels});
  }
  /// Sets to not 0 the cells of the sides of the box that may be in the object.
  void mark_open(const Constraint* known, std::uint8_t* open) const {
    const VoxelBlocks& b = coarse_.blocks;
    executor_.each_cell(b.fine, OpenVoxel{b.fine, b.coarse, b.width, known, open_, open});
  }
  /// What was learned goes, and the memory that learning takes, until the next time.
  void put_work_away() {
    all_floats_ = {};
    all_bytes_ = {};
    known_ = {};
    nearest_ = {};
    nearest_fresh_ = {};
    counts_ = {};
    ways_.reset();
    walker_.reset();
    if (looks_) looks_->put_work_away();
  }
  /// Of the executor's memory and of the host's.
  std::size_t bytes() const {
    std::size_t bytes = marks_network_.bytes() + update_network_.bytes() + painted_.bytes() + balls_.bytes() +
                        places_.bytes() + fresh_.bytes() + image_.bytes() + features_.bytes() + known_.bytes() +
                        nearest_.bytes() + nearest_fresh_.bytes() + counts_.bytes() + known_on_host_.size();
    bytes += all_floats_.bytes() + all_bytes_.bytes();
    bytes += coarse_.smoothed.size() * sizeof(float);
    for (const std::vector<float>& feature : coarse_.features) bytes += feature.size() * sizeof(float);
    if (looks_) bytes += looks_->bytes();
    if (walker_) bytes += walker_->bytes() + ways_->bytes();
    return bytes + walk_.bytes();
  }

 private:
  using Floats = typename Executor::template Array<float>;
  using Bytes = typename Executor::template Array<std::uint8_t>;

  static const PriorNetworks& networks_of(const EvidenceSettings& settings) {
    return settings.networks ? *settings.networks : learned_networks();
  }
  const BoxGrid& grid() const { return coarse_.blocks.coarse; }
  int blocks() const { return grid().count(); }
  /// A value for each block, while an update runs.
  std::array<float**, 12> float_lists() {
    return {&score_,    &from_inside_, &from_outside_, &fresh_square_,   &inside_,     &outside_,
            &edges_in_, &edges_out_,   &inward_,       &edges_to_fresh_, &squares_[0], &squares_[1]};
  }
  std::array<std::uint8_t**, 6> byte_lists() { return {&before_, &was_object_, &open_, &held_, &finite_, &prior_}; }
  /// One array for all lists.
  template <class T, std::size_t kCount>
  typename Executor::template Array<T> take(const std::array<T**, kCount>& lists) const {
    auto all = executor_.template array<T>(kCount * blocks());
    for (std::size_t l = 0; l < kCount; ++l) *lists[l] = all.data() + l * blocks();
    return all;
  }

  void take_work_out() {
    if (walker_) return;
    const std::size_t n = blocks();
    all_floats_ = take(float_lists());
    all_bytes_ = take(byte_lists());
    known_ = executor_.template array<Constraint>(n);
    nearest_ = executor_.template array<std::uint16_t>(n);
    nearest_fresh_ = executor_.template array<std::uint16_t>(n);
    counts_ = executor_.template array<int>(kBins);
    ways_.emplace(executor_, grid(), coarse_.spacing_mm, image_.data());
    walker_ = std::make_unique<ParallelWalker<Executor>>(grid(), coarse_.spacing_mm, executor_);
    executor_.copy(static_cast<const float*>(walk_.data()), walker_->field(), n);  // the last one is where it starts
  }

  void find_known(const DevicePrompts& said) {
    const PaintedBalls marks = painted_.upload(coarse_.geometry, VoxelBox{{0, 0, 0}, grid().size}, said.marks);
    const VoxelBlocks& b = coarse_.blocks;
    executor_.each_cell(
        grid(), ConstraintOfBlock{b.fine, b.coarse, b.width, marks, said.known, said.before, known_.data(), before_});
    const VoxelBox box{{0, 0, 0}, grid().size};
    const auto difference = fetch_inner_difference(executor_, grid(), coarse_.spacing_mm, image_.data(), known_.data(),
                                                   box_around_inside(painted_balls(coarse_.geometry, box, said.marks)));
    known_on_host_.resize(blocks());
    executor_.download(known_.data(), std::span<Constraint>(known_on_host_));
    inner_difference_ = received_inner_difference(executor_, difference);
  }
  /// Features that the host needs, too.
  static constexpr bool hears_within_marks(std::size_t feature) { return feature == 1 || feature == 2; }
  Strangeness strangeness_in_marks() const {
    std::array<std::vector<float>, 3> values;
    const int n = blocks();
    const auto next_inside = [&](int from) { return find_value(known_on_host_, Constraint::Inside, from, n); };
    for (int v = next_inside(0); v < n; v = next_inside(v + 1)) {
      values[0].push_back(coarse_.smoothed[v]);
      for (int s = 1; s < 3; ++s) values[s].push_back(coarse_.features[s][v]);
    }
    return strangeness_among(values);
  }

  MarkView view_of(const DevicePrompts& said) {
    const std::vector<MarkedBall> balls = marked_balls(said.marks, coarse_.geometry);
    MarkView view{};
    view.grid = grid();
    view.known = known_.data();
    view.image = image_.data();
    for (int s = 1; s < 3; ++s) view.smoothed[s - 1] = features_.data() + std::size_t(s) * blocks();
    view.score = score_;
    view.walker = walker_->field();
    view.inside = inside_, view.outside = outside_;
    view.edges_in = edges_in_, view.edges_out = edges_out_;
    view.from_inside = from_inside_, view.from_outside = from_outside_;
    view.nearest = nearest_.data();
    view.balls = balls_.set(executor_, balls);
    view.reach_mm = static_cast<float>(said.reach_mm), view.radius_mm = static_cast<float>(said.radius_mm);
    view.least_mm = least_mm();
    view.marks = static_cast<int>(balls.size());
    view.use_geodesic = settings_.use_geodesic, view.use_random_walk = settings_.use_random_walk;
    return view;
  }
  float least_mm() const {
    return static_cast<float>(*std::min_element(coarse_.spacing_mm.begin(), coarse_.spacing_mm.end()));
  }

  void find_nearest(const DevicePrompts& said, bool remembers, const MarkView& view) {
    const Eigen::Affine3d index = coarse_.geometry.index_from_world(), world = coarse_.geometry.world_from_index();
    const auto place = [&](const Eigen::Vector3d& mm) {
      const Eigen::Vector3f at = (index * mm).cast<float>();
      return IndexPlace{{at[0], at[1], at[2]}};
    };
    NearestMarks nearest{grid(),
                         {},
                         {},
                         view.balls,
                         nullptr,
                         nullptr,
                         nullptr,
                         view.marks,
                         0,
                         0,
                         known_.data(),
                         from_inside_,
                         from_outside_,
                         fresh_square_,
                         nearest_.data(),
                         nearest_fresh_.data(),
                         inside_,
                         edges_in_,
                         edges_to_fresh_};
    for (int a = 0; a < 3; ++a) {
      nearest.spacing_mm[a] = static_cast<float>(coarse_.spacing_mm[a]);
      for (int b = 0; b < 3; ++b) nearest.square_mm.mm[a][b] = static_cast<float>(world.linear()(a, b));
    }
    std::vector<IndexPlace> places;
    for (const Mark& mark : said.marks)
      if (mark.kind != MarkKind::Outside) places.push_back(place(mark.position_mm));
    nearest.inside_count = static_cast<int>(places.size());
    std::vector<NewMarkVoxel> fresh;
    if (remembers)
      for (const NewMarkBall& dot : said.fresh) {
        places.push_back(place(dot.centre_mm));
        const int voxel = nearest_block(places.back(), nearest.square_mm);
        fresh.push_back({static_cast<float>(dot.radius_mm), coarse_.smoothed[voxel], static_cast<float>(dot.depth_mm),
                         voxel, dot.inside});
      }
    nearest.fresh_count = static_cast<int>(fresh.size());
    nearest.inside = places_.set(executor_, places);
    nearest.fresh = nearest.inside + nearest.inside_count;
    nearest.fresh_balls = fresh_on_executor_ = fresh_.set(executor_, fresh);
    executor_.each_cell(grid(), nearest);
  }
  /// Of the blocks about a place; the first of several.
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
    return at * (Strangeness::kMost / (kBins - 1));
  }

  void begin_ways(bool remembers, float noise) {
    const EdgeCost changes = cost_of_changes(settings_), edges = cost_of_edges(noise);
    const std::array<typename ParallelGeodesic<Executor>::Distance, kMostDistances> ways{
        {{inside_, changes}, {edges_in_, edges}, {outside_, changes}, {edges_out_, edges}, {edges_to_fresh_, edges}}};
    ways_->begin(std::span(ways).first(remembers ? 5 : 4));
  }
  void measure_inward() {
    constexpr float everywhere_mm = 1e18f;
    executor_.each(blocks(), WasObject{before_, was_object_});
    squared_distance_to_other_side(executor_, was_object_, grid(), coarse_.spacing_mm, everywhere_mm, true, squares_[0],
                                   squares_[1]);
    executor_.each(blocks(), Inward{was_object_, squares_[0], least_mm(), inward_});
  }

  void score_looks(bool hears) {
    if (hears) {
      looks_->score(known_.data(), static_cast<float>(settings_.open_side), score_, open_);
    } else {
      executor_.clear(score_, blocks());
      executor_.clear(open_, blocks());
    }
  }

  void walk(double sharpness) {
    executor_.each(blocks(), StartWalk{known_.data(), open_, held_, finite_, walker_->field()});
    executor_.clear(prior_, blocks());  // nothing draws the walk to it
    set_edges(executor_, *walker_, coarse_.spacing_mm, image_.data(), finite_, sharpness, 0);
    walker_->solve(prior_, held_, kWalkerTolerance, settings_.most_iterations);
    executor_.copy(static_cast<const float*>(walker_->field()), walk_.data(), walk_.size());
  }

  UpdateView update_view(const DevicePrompts& said) const {
    return {image_.data(),
            before_,
            prior_,
            fresh_on_executor_,
            nearest_fresh_.data(),
            fresh_square_,
            edges_to_fresh_,
            inward_,
            static_cast<float>(1 / said.reach_mm),
            least_mm(),
            1 / cost_of_edges(noise_of(inner_difference_)).edge,
            static_cast<float>(marked_ball_count(said.marks)),
            static_cast<float>(settings_.far_memory),
            static_cast<float>(settings_.far_depths)};
  }
  static int marked_ball_count(std::span<const Mark> marks) {
    int count = 0;
    for (const Mark& mark : marks) count += mark.kind == MarkKind::Boundary ? 2 : 1;
    return count;
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
    recorded_.known = known_on_host_;
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

  void move_to_best_cut() {
    const std::vector<int> counts = received_counts(fetch_counts(BinOfCut{known_.data(), prior_}));
    executor_.each(blocks(), MoveToCut{raise_to_best_cut(std::span<const int, 256>(counts.data(), 256)), prior_});
  }

  const Executor& executor_;
  EvidenceSettings settings_;
  RunJobs run_;
  ParallelNetwork<Executor> marks_network_, update_network_;
  ConstraintVoxels<Executor> painted_;
  UploadedList<Executor, MarkedBall> balls_;
  UploadedList<Executor, IndexPlace> places_;
  UploadedList<Executor, NewMarkVoxel> fresh_;
  const NewMarkVoxel* fresh_on_executor_ = nullptr;

  bool records_ = false;
  PriorFeatures recorded_;
  CoarseImage coarse_;
  float inner_difference_ = 0;
  std::vector<Constraint> known_on_host_;
  // A value for each block, for as long as the box is the same.
  Floats image_, features_;  ///< the latter list by list
  Floats walk_;              ///< the random walker of the marks alone
  // While an update runs, a value for each block, too.
  typename Executor::template Array<Constraint> known_;
  Floats all_floats_;
  Bytes all_bytes_;
  typename Executor::template Array<std::uint16_t> nearest_, nearest_fresh_;
  std::uint8_t *before_{}, *was_object_{}, *open_{}, *held_{}, *finite_{}, *prior_{};
  float *score_{}, *from_inside_{}, *from_outside_{}, *fresh_square_{};
  float *inside_{}, *outside_{}, *edges_in_{}, *edges_out_{}, *edges_to_fresh_{}, *inward_{};
  std::array<float*, 2> squares_{};

  typename Executor::template Array<int> counts_;
  std::optional<ParallelLooks<Executor>> looks_;
  std::unique_ptr<ParallelWalker<Executor>> walker_;
  std::optional<ParallelGeodesic<Executor>> ways_;
};

}  // namespace simplexseg
