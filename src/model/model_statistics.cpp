// SPDX-License-Identifier: Apache-2.0
#include "model/model_statistics.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "model/similarity.h"

namespace simplexseg {
namespace {

constexpr int kAlignments = 5;              ///< iterations of the generalised Procrustes analysis
constexpr double kProcessDeviation = 0.06;  ///< of the Gaussian process, sizes of the mean shape, for few cases
constexpr double kProcessLength = 0.5;      ///< its correlation length, sizes
constexpr double kProcessCases = 10;        ///< number of cases that halve its variance
constexpr double kProcessTolerance = 0.01;  ///< share of the variance that its low-rank factor may miss
constexpr double kSharedCovariance = 0.15;  ///< share of the covariance of all vertices
constexpr double kLeastVariance = 1e-3;     ///< of the mean variance, added to each sample
constexpr int kCovarianceSmoothings = 2;    ///< averages of covariances over neighbours
constexpr int kFewCases = 5;                ///< below this number, covariances also contain shifted profiles
// Deviations of the pose before there are cases, which count as kPriorCases: log scale, rotation (radians), place
// (sizes), log radius.
constexpr double kScaleDeviation = 0.08, kRotationDeviation = 0.12, kPlaceDeviation = 0.15, kRadiusDeviation = 0.1;
constexpr double kPriorCases = 3;

using Points = Eigen::Matrix3Xd;

Normal normal_of(const std::vector<double>& values, double prior_deviation) {
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double sum = kPriorCases * prior_deviation * prior_deviation;
  for (const double x : values) sum += (x - mean) * (x - mean);
  return {mean, std::sqrt(sum / (n + kPriorCases))};
}
Normal3 normal_of(const std::vector<Eigen::Vector3d>& values, double prior_deviation) {
  Normal3 result;
  for (int a = 0; a < 3; ++a) {
    std::vector<double> one;
    one.reserve(values.size());
    for (const Eigen::Vector3d& v : values) one.push_back(v[a]);
    const Normal normal = normal_of(one, prior_deviation);
    result.mean[a] = normal.mean, result.deviation[a] = normal.deviation;
  }
  return result;
}

/// Mean shape of the cases after similarity alignment, centred, in the mean size and orientation of the cases.
Points mean_shape(const std::vector<const TrainedCase*>& cases) {
  Points mean = cases[0]->points.colwise() - cases[0]->points.rowwise().mean();
  const double size = size_of(mean);
  for (int k = 0; k < kAlignments; ++k) {
    Points sum = Points::Zero(3, mean.cols());
    for (const TrainedCase* one : cases) sum += fit_similarity(one->points, mean)(one->points);
    mean = sum.colwise() - sum.rowwise().mean();
    mean *= size / size_of(mean);
  }
  double log_scale = 0;
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (const TrainedCase* one : cases) {
    const Similarity pose = fit_similarity(mean, one->points);
    log_scale += std::log(pose.scale) / static_cast<double>(cases.size());
    rotations += pose.rotation;
  }
  // The rotation nearest to the mean of the matrices (Moakher 2002).
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(rotations, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d turn =
      svd.matrixU() * Eigen::Vector3d(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant()).asDiagonal() *
      svd.matrixV().transpose();
  return std::exp(log_scale) * (turn * mean);
}

/// Low-rank factor F of the kernel s^2 exp(-|p - q|^2 / (2 l^2)) between points, F F^T up to a tolerance: incomplete
/// Cholesky factorisation with pivoting (Fine and Scheinberg 2001).
Eigen::MatrixXd kernel_factor(const Points& points, double deviation, double length) {
  const Eigen::Index n = points.cols();
  Eigen::VectorXd rest = Eigen::VectorXd::Constant(n, deviation * deviation);
  std::vector<Eigen::VectorXd> columns;
  while (static_cast<Eigen::Index>(columns.size()) < n) {
    Eigen::Index pivot = 0;
    const double largest = rest.maxCoeff(&pivot);
    if (largest < kProcessTolerance * deviation * deviation) break;
    Eigen::VectorXd column =
        (-(points.colwise() - points.col(pivot)).colwise().squaredNorm().transpose().array() / (2 * length * length))
            .exp() *
        (deviation * deviation);
    for (const Eigen::VectorXd& earlier : columns) column -= earlier[pivot] * earlier;
    column /= std::sqrt(largest);
    rest -= column.cwiseAbs2();
    columns.push_back(std::move(column));
  }
  Eigen::MatrixXd factor(n, static_cast<Eigen::Index>(columns.size()));
  for (Eigen::Index c = 0; c < factor.cols(); ++c) factor.col(c) = columns[c];
  return factor;
}

}  // namespace

ShapeModel train_shape(const std::vector<std::array<int, 3>>& neighbours, const std::vector<const TrainedCase*>& cases,
                       int most_modes) {
  const Points mean = mean_shape(cases);
  const auto vertices = static_cast<int>(mean.cols()), count = static_cast<int>(cases.size());
  const double size = size_of(mean);
  const double deviation = kProcessDeviation * size * std::sqrt(kProcessCases / (count + kProcessCases));
  const Eigen::MatrixXd process = kernel_factor(mean, deviation, kProcessLength * size);
  const Eigen::Index rank = process.cols(), from_cases = count > 1 ? count : 0;
  Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(3 * vertices, from_cases + 3 * rank);
  for (Eigen::Index c = 0; c < from_cases; ++c) {
    const Points aligned = fit_similarity(cases[c]->points, mean)(cases[c]->points) - mean;
    factor.col(c) = Eigen::Map<const Eigen::VectorXd>(aligned.data(), aligned.size()) / std::sqrt(count - 1.0);
  }
  for (int v = 0; v < vertices; ++v)
    for (int a = 0; a < 3; ++a) factor.row(3 * v + a).segment(from_cases + a * rank, rank) = process.row(v);
  // Deformations that are similarities belong to the pose.
  Eigen::MatrixXd similarities(3 * vertices, 7);
  for (int v = 0; v < vertices; ++v) {
    const Eigen::Vector3d p = mean.col(v);
    similarities.block<3, 1>(3 * v, 0) = p;
    for (int a = 0; a < 3; ++a) {
      similarities.block<3, 1>(3 * v, 1 + a) = Eigen::Vector3d::Unit(a).cross(p);
      similarities.block<3, 1>(3 * v, 4 + a) = Eigen::Vector3d::Unit(a);
    }
  }
  const Eigen::MatrixXd basis =
      Eigen::HouseholderQR<Eigen::MatrixXd>(similarities).householderQ() * Eigen::MatrixXd::Identity(3 * vertices, 7);
  factor -= basis * (basis.transpose() * factor);
  // Principal components of factor factor^T, from the smaller matrix of products of its columns.
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> components(factor.transpose() * factor);
  const int modes = static_cast<int>(std::min<Eigen::Index>(most_modes, factor.cols()));
  ShapeModel shape;
  shape.mean.neighbours = neighbours;
  for (int v = 0; v < vertices; ++v) shape.mean.positions.emplace_back(mean.col(v).cast<float>());
  shape.modes = (factor * components.eigenvectors().rightCols(modes).rowwise().reverse()).cast<float>();
  std::vector<double> scales, radii;
  std::vector<Eigen::Vector3d> rotations, from_seed, from_centre;
  for (const TrainedCase* one : cases) {
    const Similarity pose = fit_similarity(mean, one->points);
    scales.push_back(std::log(pose.scale));
    rotations.push_back(rotation_vector(pose.rotation));
    from_seed.push_back(pose.shift_mm - one->seed_mm);
    from_centre.push_back(pose.shift_mm - one->centre_mm);
    radii.push_back(std::log(one->radius_mm) - scales.back());
    shape.pose.extent_mm += one->extent_mm / count;
  }
  shape.pose.log_scale = normal_of(scales, kScaleDeviation);
  shape.pose.rotation = normal_of(rotations, kRotationDeviation);
  shape.pose.from_seed = normal_of(from_seed, kPlaceDeviation * size);
  shape.pose.from_centre = normal_of(from_centre, kPlaceDeviation * size);
  shape.pose.log_radius = normal_of(radii, kRadiusDeviation);
  return shape;
}

ProfileModel train_profiles(const ProfileModel& sampling, const std::vector<std::array<int, 3>>& neighbours,
                            const std::vector<const std::vector<float>*>& profiles) {
  constexpr int kSamples = ProfileModel::kSamples, kStored = TrainedCase::kStored, kMargin = TrainedCase::kMargin;
  using Covariance = Eigen::Matrix<double, kSamples, kSamples>;
  const std::size_t vertices = neighbours.size();
  const auto count = static_cast<int>(profiles.size());
  // Profile of a vertex in a case, shifted by samples.
  const auto profile = [&](int c, std::size_t v, int shift) {
    return Eigen::Map<const Eigen::Matrix<float, 1, kSamples>>(profiles[c]->data() + v * kStored + kMargin + shift)
        .cast<double>();
  };
  ProfileModel model = sampling;
  model.mean.clear(), model.whitening.clear();
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(vertices), kSamples);
  for (int c = 0; c < count; ++c)
    for (std::size_t v = 0; v < vertices; ++v) mean.row(v) += profile(c, v, 0) / count;
  std::vector<Covariance> covariances(vertices, Covariance::Zero());
  for (std::size_t v = 0; v < vertices; ++v) {
    for (int c = 0; c < count; ++c) {
      const Eigen::RowVectorXd d = profile(c, v, 0) - mean.row(v);
      covariances[v] += d.transpose() * d / std::max(count - 1, 1);
    }
    if (count >= kFewCases) continue;
    for (int c = 0; c < count; ++c)
      for (const int shift : {-1, 1}) {
        const Eigen::RowVectorXd d = profile(c, v, shift) - profile(c, v, 0);
        covariances[v] += d.transpose() * d / (2.0 * count);
      }
  }
  for (int k = 0; k < kCovarianceSmoothings; ++k) {
    const std::vector<Covariance> old = covariances;
    for (std::size_t v = 0; v < vertices; ++v) {
      for (const int u : neighbours[v]) covariances[v] += old[u];
      covariances[v] /= 4;
    }
  }
  Covariance shared = Covariance::Zero();
  for (const Covariance& one : covariances) shared += one / static_cast<double>(vertices);
  const double least = std::max(kLeastVariance * shared.trace() / kSamples, 1e-12);
  model.mean.reserve(vertices * kSamples);
  model.whitening.reserve(vertices * ProfileModel::kWhitening);
  for (std::size_t v = 0; v < vertices; ++v) {
    for (int s = 0; s < kSamples; ++s) model.mean.push_back(static_cast<float>(mean(v, s)));
    Covariance covariance = (1 - kSharedCovariance) * covariances[v] + kSharedCovariance * shared;
    covariance.diagonal().array() += least;
    const Covariance whitening =
        Covariance(covariance.llt().matrixL()).triangularView<Eigen::Lower>().solve(Covariance::Identity());
    for (int i = 0; i < kSamples; ++i)
      for (int j = 0; j <= i; ++j) model.whitening.push_back(static_cast<float>(whitening(i, j)));
  }
  return model;
}

}  // namespace simplexseg
