// SPDX-License-Identifier: Apache-2.0
#include "model/model_fit.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "model/similarity.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr int kShifts = 12;  ///< largest shift of a search, samples
constexpr int kPlaces = 2 * kShifts + 1;
constexpr int kSamples = ProfileModel::kSamples;
constexpr int kLine = kSamples + 2 * kShifts;  ///< samples of a searched line
constexpr double kIndependentSamples = 6;      ///< independent samples of a profile
constexpr double kIndependentVertices = 80;    ///< independent shifts of a surface
constexpr double kMostCost = 9;                ///< bound of the mean squared distance of a profile in the energy
constexpr double kShiftDeviation = 2;          ///< prior deviation of a shift, samples
constexpr int kStartIterations = 6, kIterations = 20, kMarkIterations = 12;
constexpr int kStartStride = 3;         ///< every so many vertices compare orientations
constexpr int kBestStarts = 3;          ///< orientations from which the iteration is completed
constexpr double kLeastTurn = 0.15;     ///< least deviation of rotations among the starts, radians
constexpr std::array kTurns{1.7, 3.0};  ///< rotations of the starts, deviations
/// For a seed that is not in the deepest place: deviation of its place, sizes of the mean shape, and of the logarithm
/// of its radius; shifts of the starts, deviations.
constexpr double kAnywhereShift = 0.6, kAnywhereRadius = 0.4;
constexpr std::array kAnywhereShifts{-1.4, -0.7, 0.7, 1.4};
/// Largest distance of an instance from its expected place, deviations: 99.9% of a normal distribution of places.
constexpr double kExpectedDeviations = 4.03;

/// Squared Mahalanobis distances of the kCount profiles that begin at successive samples of a line. `mean`,
/// `whitening`: of the vertex.
template <int kCount>
std::array<float, kCount> profile_costs(const std::array<float, kSamples + kCount - 1>& line, const float* mean,
                                        const float* whitening) {
  std::array<std::array<float, kCount>, kSamples> difference;
  for (int j = 0; j < kSamples; ++j)
    for (int s = 0; s < kCount; ++s) difference[j][s] = line[s + j] - mean[j];
  std::array<float, kCount> costs{};
  for (int i = 0; i < kSamples; ++i) {
    std::array<float, kCount> sum{};
    for (int j = 0; j <= i; ++j) {
      const float w = *whitening++;
      for (int s = 0; s < kCount; ++s) sum[s] += w * difference[j][s];
    }
    for (int s = 0; s < kCount; ++s) costs[s] += sum[s] * sum[s];
  }
  return costs;
}

/// Width of a search in an iteration that completes an instance, kShiftDeviation.
double width_of(int iteration) {
  return iteration < kIterations / 3 ? 1.25 : iteration < 2 * kIterations / 3 ? 1.0 : 0.75;
}

int nearest_vertex(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& place) {
  Eigen::Index nearest = 0;
  (points.colwise() - place).colwise().squaredNorm().minCoeff(&nearest);
  return static_cast<int>(nearest);
}

}  // namespace

/// Distribution of the pose for a seed.
struct ModelFitter::Prior {
  PoseVector mean;
  Eigen::Matrix<double, 7, 7> precision = Eigen::Matrix<double, 7, 7>::Zero();
  double energy = 0;  ///< negative logarithm of its density at the mean, up to a constant
};

struct ModelFitter::State {
  double log_scale = 0;
  Eigen::Vector3d rotation{0, 0, 0}, shift{0, 0, 0};
  Eigen::VectorXd coefficients;

  PoseVector pose() const {
    PoseVector all;
    all << log_scale, rotation, shift;
    return all;
  }
};

ModelFitter::ModelFitter(const OrganModel& model, const Volume& volume, RunJobs run)
    : model_(model), volume_(volume), run_(std::move(run)) {}

ModelFitter::Prior ModelFitter::prior_of(const Mark* seed, bool anywhere) const {
  const PosePrior& pose = model_.shape.pose;
  Prior prior;
  prior.mean << pose.log_scale.mean, pose.rotation.mean, Eigen::Vector3d::Zero();
  prior.precision.diagonal() << 1 / std::pow(pose.log_scale.deviation, 2),
      pose.rotation.deviation.array().square().inverse().matrix(), Eigen::Vector3d::Zero();
  const auto observe = [&](int k, double value, double deviation) {
    const double precision = 1 / (deviation * deviation);
    double& present = prior.precision(k, k);
    prior.mean[k] = (prior.mean[k] * present + value * precision) / (present + precision);
    present += precision;
  };
  const VolumeGeometry& geometry = volume_.geometry();
  if (seed) {
    const auto observe_seed = [&](int k, double value, double deviation, double if_anywhere) {
      const double wide = std::hypot(deviation, anywhere ? if_anywhere : 0);
      observe(k, value, wide);
      prior.energy += std::log(wide / deviation);
    };
    observe_seed(0, std::log(seed->radius_mm) - pose.log_radius.mean, pose.log_radius.deviation, kAnywhereRadius);
    for (int a = 0; a < 3; ++a)
      observe_seed(4 + a, seed->position_mm[a] + pose.from_seed.mean[a], pose.from_seed.deviation[a],
                   kAnywhereShift * size_of(model_.shape));
  }
  if (has_similar_extent(pose, geometry) || !seed)
    for (int a = 0; a < 3; ++a)
      observe(4 + a, geometry.centre_mm()[a] + pose.from_centre.mean[a], pose.from_centre.deviation[a]);
  return prior;
}

void ModelFitter::prepare(const Mark* seed) {
  const double size = size_of(model_.shape);
  const std::array priors{prior_of(seed, false), prior_of(seed, true)};
  const Eigen::Vector3d centre = seed ? seed->position_mm : Eigen::Vector3d(priors[0].mean.tail<3>());
  image_.emplace(volume_, centre, kProfileImageRadius * size, model_.profiles, run_);
  struct Start {
    State state;
    double energy;
    bool anywhere;
  };
  std::vector<Start> starts;
  const auto add = [&](bool anywhere, const Eigen::Vector3d& turn, const Eigen::Vector3d& shift) {
    const Prior& prior = priors[anywhere];
    State state = start_of(prior, turn);
    state.shift += shift;
    for (int k = 0; k < kStartIterations; ++k) iterate(state, prior, {}, kStartStride, 1.5);
    if (!anywhere || is_inside(state, seed->position_mm))
      starts.push_back({state, energy_of(state, prior, kStartStride, nullptr), anywhere});
  };
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  add(false, none, none);
  for (const double turns : kTurns)
    for (int a = 0; a < 3; ++a)
      for (const double sign : {-1.0, 1.0})
        add(false,
            sign * turns * std::max(model_.shape.pose.rotation.deviation[a], kLeastTurn) * Eigen::Vector3d::Unit(a),
            none);
  for (int a = 0; seed && a < 3; ++a)
    for (const double shift : kAnywhereShifts)
      add(true, none, shift / std::sqrt(priors[1].precision(4 + a, 4 + a)) * Eigen::Vector3d::Unit(a));
  std::ranges::stable_sort(starts, {}, &Start::energy);
  // The best start for a seed in the deepest place is always completed: the others may lose the seed.
  const auto deepest = std::ranges::find(starts, false, &Start::anywhere);
  if (deepest >= starts.begin() + kBestStarts) std::iter_swap(deepest, starts.begin() + kBestStarts - 1);
  starts.resize(kBestStarts);
  for (Start& start : starts) {
    const Prior& prior = priors[start.anywhere];
    for (int k = 0; k < kIterations; ++k) iterate(start.state, prior, {}, 1, width_of(k));
    start.energy = energy_of(start.state, prior, 1, nullptr);
    if (start.anywhere && !is_inside(start.state, seed->position_mm))
      start.energy = std::numeric_limits<double>::infinity();
  }
  const Start& best = *std::ranges::min_element(starts, {}, &Start::energy);
  of_seed_ = std::make_shared<State>(best.state);
  anywhere_ = best.anywhere;
}

ModelFitter::State ModelFitter::start_of(const Prior& prior, const Eigen::Vector3d& turn) const {
  State state;
  state.log_scale = prior.mean[0];
  state.rotation = rotation_vector(rotation_of(turn) * rotation_of(prior.mean.segment<3>(1)));
  state.shift = prior.mean.tail<3>();
  state.coefficients = Eigen::VectorXd::Zero(model_.shape.mode_count());
  return state;
}

Eigen::Matrix3Xd ModelFitter::points_at(const State& state) const {
  return Similarity{std::exp(state.log_scale), rotation_of(state.rotation),
                    state.shift}(shape_of(model_.shape, state.coefficients));
}

bool ModelFitter::is_inside(const State& state, const Eigen::Vector3d& place) const {
  const Eigen::Matrix3Xd x = points_at(state);
  const int v = nearest_vertex(x, place);
  return normals_of(model_.shape.mean.neighbours, x).col(v).dot(place - x.col(v)) < 0;
}

void ModelFitter::iterate(State& state, const Prior& prior, std::span<const Mark> marks, int stride,
                          double widest) const {
  const ShapeModel& shape = model_.shape;
  const ProfileModel& profiles = model_.profiles;
  const int vertices = shape.vertex_count(), modes = shape.mode_count();
  const Eigen::Matrix3Xd x = points_at(state);
  const Eigen::Matrix3Xd normals = normals_of(shape.mean.neighbours, x);
  const double h = profiles.step_mm, deviation = kShiftDeviation * widest * h;
  // Expected shift of each vertex, and its precision; 0 without one.
  std::vector<double> shift(vertices, 0), weight(vertices, 0);
  const int searched = (vertices + stride - 1) / stride;
  constexpr int kVerticesPerJob = 32;
  run_((searched + kVerticesPerJob - 1) / kVerticesPerJob, [&](int job) {
    std::array<float, kLine> line;
    const int last = std::min(searched, (job + 1) * kVerticesPerJob);
    for (int at = job * kVerticesPerJob; at < last; ++at) {
      const int v = at * stride;
      if (!image_->is_in_volume(x.col(v))) continue;
      for (int s = 0; s < kLine; ++s) line[s] = image_->sample(x.col(v) + (s - kLine / 2) * h * normals.col(v));
      const std::array<float, kPlaces> costs =
          profile_costs<kPlaces>(line, &profiles.mean[std::size_t(v) * kSamples],
                                 &profiles.whitening[std::size_t(v) * ProfileModel::kWhitening]);
      std::array<double, kPlaces> log_probability;
      double largest = -std::numeric_limits<double>::infinity();
      for (int s = 0; s < kPlaces; ++s) {
        const double mm = (s - kShifts) * h;
        log_probability[s] = -0.5 * costs[s] * kIndependentSamples / kSamples - mm * mm / (2 * deviation * deviation);
        largest = std::max(largest, log_probability[s]);
      }
      double sum = 0, mean = 0, square = 0;
      for (int s = 0; s < kPlaces; ++s) {
        const double p = std::exp(log_probability[s] - largest), mm = (s - kShifts) * h;
        sum += p, mean += p * mm, square += p * mm * mm;
      }
      mean /= sum;
      shift[v] = mean;
      weight[v] = std::min(1.0, kIndependentVertices / searched) / (square / sum - mean * mean + h * h);
    }
  });
  // Marks observe single vertices. The surface passes boundary marks with a deviation of a quarter of a cell, or half
  // of a sample; how far it is from a ball on its side is known half as well.
  const double deviation_of_mark = 0.5 * std::max(h, 0.5 * image_->cell_mm());
  const auto observe = [&](int v, double mm, double deviation_mm) {
    const double precision = 1 / (deviation_mm * deviation_mm);
    shift[v] = (shift[v] * weight[v] + mm * precision) / (weight[v] + precision);
    weight[v] += precision;
  };
  for (const Mark& mark : marks) {
    const int v = nearest_vertex(x, mark.position_mm);
    const double out = normals.col(v).dot(mark.position_mm - x.col(v));  // of the mark, beyond the surface
    if (mark.kind == MarkKind::Boundary) {
      observe(v, out, deviation_of_mark);
      continue;
    }
    const double side = mark.kind == MarkKind::Inside ? 1 : -1;
    const double missing = side * out + mark.radius_mm;
    if (missing > 0) observe(v, side * missing, 2 * deviation_of_mark);
  }
  // Normal equations of the changes of pose and coefficients.
  const int unknowns = 7 + modes;
  const double scale = std::exp(state.log_scale);
  const Eigen::Matrix3d turn = scale * rotation_of(state.rotation);
  Eigen::MatrixXd rows(vertices, unknowns);
  Eigen::VectorXd right(vertices);
  int used = 0;
  for (int v = 0; v < vertices; ++v) {
    if (weight[v] == 0) continue;
    const double root = std::sqrt(weight[v]);
    const Eigen::Vector3d n = normals.col(v), y = x.col(v) - state.shift;
    rows(used, 0) = root * n.dot(y);
    rows.block<1, 3>(used, 1) = root * y.cross(n).transpose();
    rows.block<1, 3>(used, 4) = root * n.transpose();
    const Eigen::RowVector3f in_model = (root * (turn.transpose() * n)).transpose().cast<float>();
    rows.block(used, 7, 1, modes) = (in_model * shape.modes.middleRows(3 * v, 3)).cast<double>();
    right[used] = root * shift[v];
    ++used;
  }
  Eigen::VectorXd present(unknowns);  // gradient of the prior
  present << prior.precision * (state.pose() - prior.mean), state.coefficients;
  const auto j = rows.topRows(used);
  Eigen::MatrixXd matrix = j.transpose() * j;
  matrix.topLeftCorner<7, 7>() += prior.precision;
  matrix.diagonal().tail(modes).array() += 1;
  const Eigen::VectorXd change = matrix.ldlt().solve(j.transpose() * right.head(used) - present);
  state.log_scale += change[0];
  state.rotation = rotation_vector(rotation_of(change.segment<3>(1)) * rotation_of(state.rotation));
  state.shift += change.segment<3>(4);
  state.coefficients += change.tail(modes);
}

double ModelFitter::energy_of(const State& state, const Prior& prior, int stride, double* mean_cost) const {
  const ProfileModel& profiles = model_.profiles;
  const int vertices = model_.shape.vertex_count();
  const Eigen::Matrix3Xd x = points_at(state);
  const Eigen::Matrix3Xd normals = normals_of(model_.shape.mean.neighbours, x);
  double sum = 0;
  int visible = 0;
  for (int v = 0; v < vertices; v += stride) {
    if (!image_->is_in_volume(x.col(v))) continue;
    std::array<float, kSamples> profile;
    for (int s = 0; s < kSamples; ++s)
      profile[s] = image_->sample(x.col(v) + (s - ProfileModel::kHalf) * profiles.step_mm * normals.col(v));
    const double cost = profile_costs<1>(profile, &profiles.mean[std::size_t(v) * kSamples],
                                         &profiles.whitening[std::size_t(v) * ProfileModel::kWhitening])[0];
    sum += std::min(cost / kSamples, kMostCost);
    ++visible;
  }
  const double mean = visible > 0 ? sum / visible : kMostCost;
  if (mean_cost) *mean_cost = mean;
  const PoseVector difference = state.pose() - prior.mean;
  const double pose = difference.dot(prior.precision * difference);
  return prior.energy +
         0.5 * (kIndependentVertices * kIndependentSamples * mean + 0.5 * pose + state.coefficients.squaredNorm());
}

ModelFit ModelFitter::fit(std::span<const Mark> marks) {
  const auto inside = std::ranges::find(marks, MarkKind::Inside, &Mark::kind);
  const Mark* const seed = inside == marks.end() ? nullptr : &*inside;
  if (!of_seed_ || seed_.has_value() != (seed != nullptr) || (seed && *seed_ != *seed)) {
    seed_.reset();
    if (seed) seed_ = *seed;
    prepare(seed);
  }
  const Prior prior = prior_of(seed, anywhere_);
  State state = *of_seed_;
  std::span<const Mark> others = marks;
  if (marks.size() == 1 && seed) others = {};
  for (int k = 0; k < (others.empty() ? 0 : kMarkIterations); ++k) iterate(state, prior, others, 1, 0.75);
  ModelFit result;
  if (seed) {
    const PosePrior& pose = model_.shape.pose;
    result.size_deviations = std::abs(std::log(seed->radius_mm) - pose.log_radius.mean - pose.log_scale.mean) /
                             std::hypot(pose.log_radius.deviation, pose.log_scale.deviation);
  }
  energy_of(state, prior, 1, &result.cost);
  result.points = points_at(state);
  return result;
}

std::optional<ModelFit> ModelFitter::fit_at(const PoseDistribution& expected) {
  Prior prior;
  prior.mean = expected.mean;
  prior.precision = expected.covariance.inverse();
  const Eigen::Matrix3d place = expected.covariance.bottomRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(place);
  const double radius =
      kProfileImageRadius * size_of(model_.shape) + kExpectedDeviations * std::sqrt(axes.eigenvalues()[2]);
  image_.emplace(volume_, expected.mean.tail<3>(), radius, model_.profiles, run_);
  seed_.reset(), of_seed_.reset();
  const auto is_probable = [&](const State& state) {
    const Eigen::Vector3d away = state.shift - expected.mean.tail<3>();
    return away.dot(place.ldlt().solve(away)) < kExpectedDeviations * kExpectedDeviations;
  };
  std::vector<std::pair<double, State>> starts;
  const auto add = [&](const Eigen::Vector3d& turn, const Eigen::Vector3d& shift) {
    State state = start_of(prior, turn);
    state.shift += shift;
    for (int k = 0; k < kStartIterations; ++k) iterate(state, prior, {}, kStartStride, 1.5);
    if (is_probable(state)) starts.emplace_back(energy_of(state, prior, kStartStride, nullptr), state);
  };
  const Eigen::Vector3d none = Eigen::Vector3d::Zero();
  add(none, none);
  for (const double turns : kTurns)
    for (int a = 0; a < 3; ++a)
      for (const double sign : {-1.0, 1.0})
        add(sign * turns * std::max(std::sqrt(expected.covariance(1 + a, 1 + a)), kLeastTurn) *
                Eigen::Vector3d::Unit(a),
            none);
  for (int a = 0; a < 3; ++a)
    for (const double shift : kAnywhereShifts)
      add(none, shift * std::sqrt(axes.eigenvalues()[a]) * axes.eigenvectors().col(a));
  std::ranges::stable_sort(starts, {}, [](const auto& start) { return start.first; });
  if (starts.size() > kBestStarts) starts.resize(kBestStarts);
  std::erase_if(starts, [&](auto& start) {
    auto& [energy, state] = start;
    for (int k = 0; k < kIterations; ++k) iterate(state, prior, {}, 1, width_of(k));
    energy = energy_of(state, prior, 1, nullptr);
    return !is_probable(state);
  });
  const auto best = std::ranges::min_element(starts, {}, [](const auto& start) { return start.first; });
  if (best == starts.end()) return std::nullopt;
  ModelFit result;
  energy_of(best->second, prior, 1, &result.cost);
  result.points = points_at(best->second);
  return result;
}

}  // namespace simplexseg
