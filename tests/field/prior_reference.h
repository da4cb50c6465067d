// SPDX-License-Identifier: Apache-2.0
// Prompts of several objects, and the features of the prior by short and slow methods.
#pragma once
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "core/quantile.h"
#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "field/field_voxel.h"
#include "field/mark_measures.h"
#include "field/parallel/cpu_executor.h"
#include "field/parallel/prior.h"
#include "field/seed_scale.h"
#include "references.h"

namespace simplexseg {

inline Mark boundary(const Eigen::Vector3d& at, double radius, const Eigen::Vector3d& outward) {
  return {MarkKind::Boundary, at, radius, outward};
}

/// Prompts of an object in a box: first marks, for which a field was solved, and new ones.
class Story {
 public:
  Story(const Volume& volume, std::vector<Mark> first, const std::vector<Mark>& then,
        const std::vector<Mark>& others = {})
      : volume_(volume), marks_(std::move(first)) {
    EvidenceField field(volume);
    field.update(marks_, others);
    box_ = field.box();
    if (!then.empty())
      for (const float p : field.probability()) previous_.push_back(to_8_bits(p));
    for (const Mark& mark : then) add(mark);
    prepare(others);
  }
  /// Single seed in a separate box.
  Story(const VoxelBox& box, const Volume& volume, const Mark& seed) : volume_(volume), marks_{seed}, box_(box) {
    prepare({});
  }

  template <class Executor>
  ParallelPrior<Executor> computed(const Executor& executor, const EvidenceSettings& settings = {}) const {
    ParallelPrior<Executor> prior(executor, settings, run_serially());
    prior.set_box(image_, volume_.geometry(), box_.first, scale_mm_);
    prior.record_features(true);
    compute(prior);
    return prior;
  }
  template <class Executor>
  void compute(ParallelPrior<Executor>& prior) const {
    prior.compute({marks_, constraints_.data(), previous_.empty() ? nullptr : previous_.data(), new_balls_, scale_mm_,
                   radius_mm_});
  }
  template <class Executor>
  std::vector<std::uint8_t> voxels_of(const ParallelPrior<Executor>& prior) const {
    std::vector<std::uint8_t> voxels(constraints_.size());
    prior.interpolate(smoothed_.data(), kEdge, voxels.data());
    return voxels;
  }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  const std::vector<std::uint8_t>& previous() const { return previous_; }
  std::span<const Mark> marks() const { return marks_; }
  std::span<const NewMarkBall> new_balls() const { return new_balls_; }
  double scale_mm() const { return scale_mm_; }
  double radius_mm() const { return radius_mm_; }
  CoarseImage coarse() const {
    return coarse_image(volume_.geometry(), image_, box_.first, scale_mm_, {}, run_serially());
  }

 private:
  static constexpr float kEdge = 0.02f;

  void prepare(std::span<const Mark> others) {
    image_ = extract_box(volume_, kVoxelCells, box_, run_serially());
    constraints_ = constraint_mask(volume_.geometry(), box_, image_.finite, marks_, others);
    const auto largest = std::max_element(marks_.begin(), marks_.end(),
                                          [](const Mark& a, const Mark& b) { return size_of(a) < size_of(b); });
    radius_mm_ = largest->radius_mm;
    scale_mm_ = seed_scale(volume_, largest->position_mm, largest->radius_mm).scale_mm;
    smoothed_ = image_.value;
    std::array<double, 3> spacing_mm;
    for (int a = 0; a < 3; ++a) spacing_mm[a] = volume_.geometry().spacing_mm[a];
    smooth_by_least_spacing(smoothed_, image_.grid, spacing_mm, 0.7, run_serially());
  }
  static double size_of(const Mark& mark) { return mark.kind == MarkKind::Outside ? 0 : mark.radius_mm; }
  void add(const Mark& mark) {
    marks_.push_back(mark);
    const Eigen::Vector3d step = ball_offset(mark);
    if (mark.kind != MarkKind::Outside) add_ball(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add_ball(mark.position_mm + step, mark.radius_mm, false);
  }
  void add_ball(const Eigen::Vector3d& at, double radius_mm, bool inside) {
    const Eigen::Affine3d world = volume_.geometry().world_from_index();
    const auto mm_to = [&](int i, int j, int k) {
      return (world * Eigen::Vector3d(box_.first[0] + i, box_.first[1] + j, box_.first[2] + k) - at).norm();
    };
    double nearest = 1e6, least = 1e6;
    bool object = false;
    each_index({box_.size}, [&](int i, int j, int k, int v) {
      if (mm_to(i, j, k) < nearest) nearest = mm_to(i, j, k), object = previous_[v] > kPreviousThreshold;
    });
    each_index({box_.size}, [&](int i, int j, int k, int v) {
      if ((previous_[v] > kPreviousThreshold) != object) least = std::min(least, mm_to(i, j, k));
    });
    new_balls_.push_back({at, radius_mm, inside, least});
  }

  Volume volume_;
  std::vector<Mark> marks_;
  VoxelBox box_;
  std::vector<std::uint8_t> previous_;
  std::vector<NewMarkBall> new_balls_;
  BoxImage image_;
  std::vector<float> smoothed_;
  std::vector<Constraint> constraints_;
  double radius_mm_, scale_mm_;
};

struct Named {
  std::string name;
  Story story;
};
inline std::vector<Named> make_stories() {
  std::vector<Named> all;
  const Scene noisy = ellipsoid(36, 1, {12, 10, 9}, 25), clean = ellipsoid(36, 1, {12, 10, 10}, 3),
              thick = ellipsoid(64, 4, {18, 14, 16}, 10), large = ellipsoid(64, 1, {24, 18, 20}, 20);
  const std::vector<Mark> seed{inside({0, 0, 0}, 8)};
  all.push_back({"noisy seed", Story(noisy.image, seed, {})});
  all.push_back({"noisy, outside", Story(noisy.image, seed, {outside({15, 0, 0}, 3)})});
  all.push_back({"noisy, inside and boundary",
                 Story(noisy.image, seed, {inside({9, 3, 1}, 2), boundary({0, 10, 0}, 2.5, {0, 1, 0})})});
  all.push_back({"clean seed", Story(clean.image, {inside({0, 0, 0}, 6)}, {})});
  all.push_back({"clean, contradicting",
                 Story(clean.image, {inside({0, 0, 0}, 6)}, {inside({0, 13, 0}, 2), outside({9, 0, 0}, 2)})});
  all.push_back({"thick slices", Story(thick.image, {inside({0, 0, 0}, 10)},
                                       {outside({20.3, 1, 0}, 2.7), boundary({0, 0, 16}, 3, {0.3, 0.1, 1})})});
  all.push_back({"large seed", Story(large.image, {inside({0.2, 0.1, 0}, 15)}, {})});
  all.push_back({"large, clicks", Story(large.image, {inside({0.2, 0.1, 0}, 15)},
                                        {outside({28, 0, 0}, 4), boundary({0, 18, 0}, 3, {0.1, 1, 0})})});
  {
    VolumeGeometry geometry = clean.image.geometry();
    geometry.direction << 1, 0.2, 0.1, 0, 1, 0.1, 0.1, 0, 1;
    geometry.spacing_mm = {0.7, 0.9, 1.3};
    Volume volume(geometry, VoxelType::Float32);
    std::copy_n(clean.image.voxels<float>().begin(), geometry.voxel_count(), volume.voxels<float>().begin());
    for (int v = 0; v < 1400; ++v) volume.voxels<float>()[v * 31] = std::numeric_limits<float>::quiet_NaN();
    const Eigen::Affine3d mm = geometry.world_from_index();
    all.push_back({"sheared, not finite, others", Story(volume, {inside(mm * Eigen::Vector3d(18, 18, 18), 4.9)},
                                                        {outside(mm * Eigen::Vector3d(18, 30, 19), 2.1),
                                                         boundary(mm * Eigen::Vector3d(18, 8, 18), 2.1, {0, -1, 0.2})},
                                                        {inside(mm * Eigen::Vector3d(32, 18, 18), 2.5)})});
  }
  {
    Scene cut = ellipsoid(40, 1, {26, 10, 10}, 10);  // cut by the volume
    all.push_back({"at the volume's edge", Story(cut.image, {inside({10, 0, 0}, 9)}, {inside({18, 1, 0}, 2)})});
  }
  return all;
}

inline const std::vector<Named>& stories() {
  static const std::vector<Named> all = make_stories();
  return all;
}

/// Measures of all blocks by short and slow methods, and the features of both networks from them.
class Reference {
 public:
  Reference(const Story& story, const EvidenceSettings& settings = {})
      : story_(story),
        coarse_(story.coarse()),
        world_(coarse_.geometry.world_from_index()),
        n_(coarse_.blocks.coarse.count()),
        settings_(settings) {
    find_constraints();
    measure_difference();
    balls_ = marked_balls(story.marks(), coarse_.geometry);
    find_new_marks();
  }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  /// Whether several balls are about equally near, so that any of them may be the nearest.
  bool is_between_balls(int v) const { return between_[v] != 0; }
  bool is_between_new(int v) const { return between_new_[v] != 0; }

  std::vector<std::vector<float>> mark_features() {
    measure_distances();
    score();
    solve_random_walker();
    measure_z_score();
    MarkView view{};
    view.grid = grid(), view.constraints = constraints_.data(), view.image = coarse_.smoothed.data();
    for (int s = 0; s < 2; ++s) view.smoothed[s] = coarse_.features[s + 1].data();
    view.score = score_.data(), view.walker = random_walker_.data();
    view.inside = inside_.data(), view.outside = outside_.data();
    view.edges_in = edges_in_.data(), view.edges_out = edges_out_.data();
    view.from_inside = from_inside_.data(), view.from_outside = from_outside_.data();
    view.nearest = nearest_.data(), view.balls = balls_.data();
    view.z_score = z_score_, view.inverse_deviation = z_score_.inverse_deviation[0], view.noise = noise_,
    view.shell_contrast = shell_contrast_;
    view.scale_mm = static_cast<float>(story_.scale_mm()), view.radius_mm = static_cast<float>(story_.radius_mm());
    view.least_spacing_mm = least_spacing_mm(), view.marks = static_cast<int>(balls_.size());
    view.use_geodesic = view.use_random_walk = true;
    return listed(view);
  }
  /// `prior_of_marks`: outputs of the network of all marks.
  std::vector<std::vector<float>> update_features(const std::vector<std::uint8_t>& prior_of_marks) {
    measure_new_marks();
    return listed(update_view(prior_of_marks));
  }
  std::vector<std::uint8_t> near_inside() const {
    std::vector<std::uint8_t> inside(n_);
    for (int v = 0; v < n_; ++v) inside[v] = new_balls_[nearest_new_[v]].inside;
    return inside;
  }
  /// Prior of a block: output of the network of new marks for the side of the nearest one, and, from one to two depths
  /// of that mark on, half of the previous field.
  double prior_of(int v, double same_side) const {
    const NewMarkVoxel& mark = new_balls_[nearest_new_[v]];
    const double now = mark.inside ? same_side : 255 - same_side,
                 depths = std::sqrt(square_[v]) / (mark.depth_mm + 0.5 * least_spacing_mm());
    const double old =
        previous_[v] == 0 ? 0 : settings_.far_memory * std::clamp(depths / settings_.far_depths - 1, 0.0, 1.0);
    return now + old * (previous_[v] - now);
  }

 private:
  UpdateView update_view(const std::vector<std::uint8_t>& prior_of_marks) const {
    return {coarse_.smoothed.data(),
            previous_.data(),
            prior_of_marks.data(),
            new_balls_.data(),
            nearest_new_.data(),
            square_.data(),
            edges_to_new_.data(),
            inward_.data(),
            static_cast<float>(1 / story_.scale_mm()),
            least_spacing_mm(),
            1 / (3 * noise_),
            static_cast<float>(balls_.size()),
            static_cast<float>(settings_.far_memory),
            static_cast<float>(settings_.far_depths)};
  }

  const BoxGrid& grid() const { return coarse_.blocks.coarse; }
  float least_spacing_mm() const { return static_cast<float>(*std::ranges::min_element(coarse_.spacing_mm)); }
  template <class View>
  std::vector<std::vector<float>> listed(const View& view) const {
    std::vector<std::vector<float>> all(View::kFeatures, std::vector<float>(n_));
    for (int v = 0; v < n_; ++v) view.fill(v, [&](int f, float value) { all[f][v] = value; });
    return all;
  }
  static std::vector<float> as_floats(const std::vector<double>& values) { return {values.begin(), values.end()}; }
  template <class Is>
  std::vector<float> distances(const EdgeCost& cost, const Is& is) const {
    std::vector<std::uint8_t> start(n_);
    for (int v = 0; v < n_; ++v) start[v] = is(v);
    return as_floats(dijkstra(start, coarse_.smoothed, grid(), coarse_.spacing_mm, cost));
  }
  double mm2(int v, const Eigen::Vector3d& place_mm) const {
    const Eigen::Vector3d index(v % grid().row(), v / grid().row() % grid().size[1], v / grid().plane());
    return (world_ * index - place_mm).squaredNorm();
  }

  /// A block is not finite or outside if half of its voxels are; else it has the constraint of the side of the box.
  void find_constraints() {
    std::vector<std::array<int, 6>> count(n_);
    std::vector<int> all(n_), sum(n_), previous_count(n_);
    const BoxGrid& fine = coarse_.blocks.fine;
    each_index(fine, [&](int i, int j, int k, int v) {
      const std::array<int, 3>& w = coarse_.blocks.width;
      const int b = (k / w[2] * grid().size[1] + j / w[1]) * grid().size[0] + i / w[0];
      const Constraint at = story_.constraints()[v];
      ++all[b];
      count[b][0] += at == Constraint::NotFinite, count[b][1] += at == Constraint::Outside;
      count[b][2] += at == Constraint::FarBorder, count[b][3] += at == Constraint::VolumeEdge;
      if (story_.previous().empty() || story_.previous()[v] == 0) return;
      sum[b] += story_.previous()[v], ++previous_count[b];
    });
    for (int b = 0; b < n_; ++b) {
      constraints_.push_back(2 * count[b][0] >= all[b]   ? Constraint::NotFinite
                             : 2 * count[b][1] >= all[b] ? Constraint::Outside
                             : count[b][2] > 0           ? Constraint::FarBorder
                             : count[b][3] > 0           ? Constraint::VolumeEdge
                                                         : Constraint::None);
      previous_.push_back(static_cast<std::uint8_t>(
          previous_count[b] == 0 ? 0 : std::lround(std::floor(0.5 + double(sum[b]) / previous_count[b]))));
    }
    paint_marks(constraints_, coarse_.geometry, {{0, 0, 0}, grid().size}, story_.marks());
  }
  /// 75th percentile of the differences of neighbours in inside marks along the axes with narrow spacing.
  void measure_difference() {
    std::vector<float> differences;
    for (int a = 0; a < 3; ++a) {
      if (coarse_.spacing_mm[a] >= 2 * least_spacing_mm()) continue;
      each_index(grid(), [&](int i, int j, int k, int v) {
        const int at[3]{i, j, k}, u = v + grid().stride(a);
        if (at[a] + 1 < grid().size[a] && constraints_[v] == Constraint::Inside &&
            constraints_[u] == Constraint::Inside)
          differences.push_back(std::fabs(coarse_.smoothed[u] - coarse_.smoothed[v]));
      });
    }
    difference_ = differences.size() < 20 ? 0 : quantile(differences, 0.75);
    noise_ = difference_ + 0.01f;
  }
  /// Distances to balls are those of orthogonal axes.
  void measure_distances() {
    nearest_.resize(n_), between_.resize(n_);
    from_inside_.assign(n_, 1e12f), from_outside_.assign(n_, 1e12f);
    for (int v = 0; v < n_; ++v) {
      for (const Mark& mark : story_.marks())
        if (mark.kind != MarkKind::Outside)
          from_inside_[v] = std::min(from_inside_[v], static_cast<float>(mm2(v, mark.position_mm)));
      double least = 1e12, second = 1e12;
      for (std::size_t b = 0; b < balls_.size(); ++b) {
        const int at[3]{v % grid().row(), v / grid().row() % grid().size[1], v / grid().plane()};
        double square = 0;
        for (int a = 0; a < 3; ++a) square += std::pow((at[a] - balls_[b].index[a]) * coarse_.spacing_mm[a], 2);
        if (!balls_[b].inside) {
          from_outside_[v] = std::min(from_outside_[v], static_cast<float>(square));
        } else if (square < least) {
          second = least, least = square;
          nearest_[v] = static_cast<std::uint16_t>(b);
        } else {
          second = std::min(second, square);
        }
      }
      between_[v] = second < 1.001 * least + 1e-3;
    }
  }
  void find_new_marks() {
    nearest_new_.resize(n_), between_new_.resize(n_), in_new_.resize(n_), square_.assign(n_, 1e12f);
    for (const NewMarkBall& ball : story_.new_balls()) {
      std::vector<double> square(n_);
      for (int v = 0; v < n_; ++v) square[v] = mm2(v, ball.centre_mm);
      int nearest = 0;
      for (int v = 0; v < n_; ++v)
        if (square[v] < square[nearest] - 1e-6) nearest = v;
      const auto number = static_cast<std::uint16_t>(new_balls_.size());
      new_balls_.push_back({static_cast<float>(ball.radius_mm), coarse_.smoothed[nearest],
                            static_cast<float>(ball.depth_mm), nearest, ball.inside});
      for (int v = 0; v < n_; ++v) {
        if (v == nearest || square[v] <= ball.radius_mm * ball.radius_mm) in_new_[v] = 1;
        if (std::fabs(square[v] - square_[v]) < 1e-3 * square[v] + 1e-3) between_new_[v] = 1;
        if (square[v] < square_[v]) square_[v] = static_cast<float>(square[v]), nearest_new_[v] = number;
      }
    }
  }
  void measure_new_marks() {
    edges_to_new_ = distances({0.002f, 3 * noise_}, [&](int v) { return in_new_[v] != 0; });
    std::vector<std::uint8_t> set(n_), rest(n_);
    for (int v = 0; v < n_; ++v) set[v] = previous_[v] > 127, rest[v] = !set[v];
    const Eigen::Matrix3d mm =
        Eigen::Vector3d(coarse_.spacing_mm[0], coarse_.spacing_mm[1], coarse_.spacing_mm[2]).asDiagonal();
    const VoxelBox box{{0, 0, 0}, grid().size};
    const std::vector<float> to_set = distance_map(set, box, mm), to_rest = distance_map(rest, box, mm);
    inward_.resize(n_);
    for (int v = 0; v < n_; ++v) inward_[v] = inward_mm(set[v] ? to_rest[v] : to_set[v], set[v], least_spacing_mm());
  }
  /// Ridge regression by the normal equations in double.
  void score() {
    const ClassifierSettings ridge;
    const int features = static_cast<int>(coarse_.features.size());
    const FourierTerms terms = fourier_terms(ridge, features);
    const auto row = [&](int v) {
      Eigen::VectorXd x(ridge.terms);
      for (int t = 0; t < ridge.terms; ++t) {
        double angle = terms.phase[t];
        for (int f = 0; f < features; ++f) angle += double{terms.frequency[t * features + f]} * coarse_.features[f][v];
        x[t] = std::sqrt(2.0 / ridge.terms) * cosine_of_turns(static_cast<float>(angle));
      }
      return x;
    };
    const AppearanceSamples samples = appearance_samples(constraints_, settings_);
    score_.assign(n_, 0), open_.assign(n_, 0);
    if (!settings_.use_appearance || samples.inside.empty() || samples.outside.empty()) return;
    Eigen::MatrixXd gram = ridge.ridge * Eigen::MatrixXd::Identity(ridge.terms, ridge.terms);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(ridge.terms);
    for (const bool in : {true, false}) {
      const std::vector<ClassifierSample>& some = in ? samples.inside : samples.outside;
      double total = 0;
      for (const ClassifierSample& s : some) total += s.weight;
      for (const ClassifierSample& s : some) {
        const Eigen::VectorXd x = row(s.voxel);
        gram.selfadjointView<Eigen::Lower>().rankUpdate(x, s.weight / total);
        right += (in ? 1 : -1) * s.weight / total * x;
      }
    }
    const Eigen::VectorXd w = gram.selfadjointView<Eigen::Lower>().llt().solve(right);
    for (int v = 0; v < n_; ++v) {
      score_[v] = static_cast<float>(row(v).dot(w));
      open_[v] = constraints_[v] == Constraint::FarBorder && score_[v] > settings_.open_side;
    }
  }
  /// Geodesic distances, and the random walker of the marks alone, which random_walker_test.cpp tests.
  void solve_random_walker() {
    const EdgeCost changes{static_cast<float>(settings_.length_cost), 0}, edges{0.002f, 3 * noise_};
    const auto in = [&](int v) { return constraints_[v] == Constraint::Inside; };
    const auto out = [&](int v) { return !in(v) && constraints_[v] != Constraint::None && !open_[v]; };
    inside_ = distances(changes, in), edges_in_ = distances(edges, in);
    outside_ = distances(changes, out), edges_out_ = distances(edges, out);
    const CpuFieldExecutor executor;
    ParallelWalker<CpuFieldExecutor> walker(grid(), coarse_.spacing_mm, executor);
    std::vector<std::uint8_t> fixed(n_), finite(n_);
    const std::vector<std::uint8_t> target(n_);
    for (int v = 0; v < n_; ++v) {
      fixed[v] = in(v) || out(v), finite[v] = constraints_[v] != Constraint::NotFinite;
      walker.field()[v] = in(v) ? 1.0f : 0.0f;
    }
    set_edges(executor, walker, coarse_.spacing_mm, coarse_.smoothed.data(), finite.data(),
              sharpness_of(difference_, settings_), 0);
    walker.solve(target.data(), fixed.data(), kWalkerTolerance, settings_.most_iterations);
    random_walker_.assign(walker.field(), walker.field() + n_);
  }
  void measure_z_score() {
    for (int l = 0; l < 3; ++l) {
      const std::vector<float>& image = l == 0 ? coarse_.smoothed : coarse_.features[l];
      std::vector<float> values;
      for (int v = 0; v < n_; ++v)
        if (constraints_[v] == Constraint::Inside) values.push_back(image[v]);
      ASSERT_FALSE(values.empty());
      z_score_.median[l] = quantile(values, 0.5);
      for (float& x : values) x = std::fabs(x - z_score_.median[l]);
      z_score_.inverse_deviation[l] = 1 / (1.4826f * quantile(values, 0.5) + (l == 0 ? 0.01f : 0.03f));
    }
    std::vector<float> shell;
    for (int v = 0; v < n_; ++v) {
      const double scales = std::sqrt(from_inside_[v]) / story_.scale_mm();
      if (scales <= 1.15 || scales >= 1.7 || constraints_[v] == Constraint::NotFinite) continue;
      shell.push_back(
          std::min(std::fabs(coarse_.smoothed[v] - z_score_.median[0]) * z_score_.inverse_deviation[0], 6.0f));
    }
    shell_contrast_ = shell.empty() ? 0 : quantile(shell, 0.5);
  }

  const Story& story_;
  CoarseImage coarse_;
  Eigen::Affine3d world_;
  int n_;
  EvidenceSettings settings_;
  std::vector<Constraint> constraints_;
  std::vector<std::uint8_t> previous_, between_, between_new_, in_new_, open_;
  std::vector<MarkedBall> balls_;
  std::vector<NewMarkVoxel> new_balls_;
  std::vector<std::uint16_t> nearest_, nearest_new_;
  std::vector<float> from_inside_, from_outside_, square_, inward_, score_, random_walker_;
  std::vector<float> inside_, outside_, edges_in_, edges_out_, edges_to_new_;
  IntensityZScore z_score_;
  float difference_ = 0, noise_ = 0, shell_contrast_ = 0;
};

}  // namespace simplexseg
