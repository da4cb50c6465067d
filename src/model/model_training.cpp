// SPDX-License-Identifier: Apache-2.0
#include "model/model_training.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/error.h"
#include "field/robot_user.h"
#include "image/gaussian.h"
#include "image/label_surface.h"
#include "mesh/mesh_geometry.h"
#include "model/model_fit.h"
#include "model/profile_image.h"
#include "model/similarity.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr int kSurfaceDensity = 4;  ///< vertices of the surface of a case per vertex of the template
/// Standard deviations of the Gaussians that simplify the mask of a template, voxels: the first with few folds is used.
constexpr std::array kTemplateSmoothing{0.0, 0.7, 1.0, 1.5};
constexpr double kMostFolded = 0.02;                        ///< share of folded vertices of a template
constexpr int kLeastVertices = 1000, kMostVertices = 2500;  ///< of a template, unless the number is given
constexpr double kLargestEdge = 0.35;                       ///< mean edge of a template, depths of the object
constexpr int kAlignments = 5;                              ///< iterations of the generalised Procrustes analysis
constexpr double kProcessDeviation = 0.06;  ///< of the Gaussian process, sizes of the mean shape, for few cases
constexpr double kProcessLength = 0.5;      ///< its correlation length, sizes
constexpr double kProcessCases = 10;        ///< number of cases that halve its variance
constexpr double kProcessTolerance = 0.01;  ///< share of the variance that its low-rank factor may miss
constexpr double kSamplesPerSize = 28;      ///< profile samples per size
constexpr double kSurroundings = 1.6;       ///< ProfileModel::surroundings_mm, sizes
constexpr double kSharedCovariance = 0.15;  ///< share of the covariance of all vertices
constexpr double kLeastVariance = 1e-3;     ///< of the mean variance, added to each sample
constexpr int kCovarianceSmoothings = 2;    ///< averages of covariances over neighbours
constexpr int kFewCases = 5;                ///< below this number, covariances also contain shifted profiles
// Deviations of the pose before there are cases, which count as kPriorCases: log scale, rotation (radians), place
// (sizes), log radius.
constexpr double kScaleDeviation = 0.08, kRotationDeviation = 0.12, kPlaceDeviation = 0.15, kRadiusDeviation = 0.1;
constexpr double kPriorCases = 3;
constexpr int kFolds = 5;               ///< of the cross-validation
constexpr double kUnknownError = 0.06;  ///< surface_error_mm without cross-validation, sizes

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
Points mean_shape(const std::vector<const RegisteredCase*>& cases) {
  Points mean = cases[0]->points.colwise() - cases[0]->points.rowwise().mean();
  const double size = size_of(mean);
  for (int k = 0; k < kAlignments; ++k) {
    Points sum = Points::Zero(3, mean.cols());
    for (const RegisteredCase* one : cases) sum += fit_similarity(one->points, mean)(one->points);
    mean = sum.colwise() - sum.rowwise().mean();
    mean *= size / size_of(mean);
  }
  double log_scale = 0;
  Eigen::Matrix3d rotations = Eigen::Matrix3d::Zero();
  for (const RegisteredCase* one : cases) {
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

ShapeModel train_shape(const SimplexMesh& mesh, const std::vector<const RegisteredCase*>& cases, int most_modes) {
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
  shape.mean.neighbours = mesh.neighbours;
  for (int v = 0; v < vertices; ++v) shape.mean.positions.emplace_back(mean.col(v).cast<float>());
  shape.modes = (factor * components.eigenvectors().rightCols(modes).rowwise().reverse()).cast<float>();
  std::vector<double> scales, radii;
  std::vector<Eigen::Vector3d> rotations, from_seed, from_centre;
  for (const RegisteredCase* one : cases) {
    const Similarity pose = fit_similarity(mean, one->points);
    const VolumeGeometry& grid = one->data->image.geometry();
    scales.push_back(std::log(pose.scale));
    rotations.push_back(rotation_vector(pose.rotation));
    from_seed.push_back(pose.shift_mm - one->seed_mm);
    from_centre.push_back(pose.shift_mm - grid.centre_mm());
    radii.push_back(std::log(one->radius_mm) - scales.back());
    shape.pose.extent_mm += extent_mm(grid) / count;
  }
  shape.pose.log_scale = normal_of(scales, kScaleDeviation);
  shape.pose.rotation = normal_of(rotations, kRotationDeviation);
  shape.pose.from_seed = normal_of(from_seed, kPlaceDeviation * size);
  shape.pose.from_centre = normal_of(from_centre, kPlaceDeviation * size);
  shape.pose.log_radius = normal_of(radii, kRadiusDeviation);
  return shape;
}

/// Profiles of all vertices, V x kSamples.
Eigen::MatrixXd profiles_at(const ProfileImage& image, const std::vector<std::array<int, 3>>& neighbours,
                            const Points& points, double step_mm, double shift) {
  const Points normals = normals_of(neighbours, points);
  Eigen::MatrixXd profiles(points.cols(), ProfileModel::kSamples);
  for (Eigen::Index v = 0; v < points.cols(); ++v)
    for (int s = 0; s < ProfileModel::kSamples; ++s)
      profiles(v, s) = image.sample(points.col(v) + (s - ProfileModel::kHalf + shift) * step_mm * normals.col(v));
  return profiles;
}

ProfileModel train_profiles(const ShapeModel& shape, const std::vector<const RegisteredCase*>& cases,
                            IntensityScale scale, const RunJobs& run) {
  constexpr int kSamples = ProfileModel::kSamples;
  using Covariance = Eigen::Matrix<double, kSamples, kSamples>;
  const auto vertices = static_cast<std::size_t>(shape.vertex_count());
  const double size = size_of(shape);
  ProfileModel model;
  model.scale = scale;
  model.step_mm = size / kSamplesPerSize;
  model.surroundings_mm = kSurroundings * size;
  const auto count = static_cast<int>(cases.size());
  for (const RegisteredCase* one : cases) model.cell_mm += one->data->image.geometry().spacing_mm.minCoeff() / count;
  std::vector<Eigen::MatrixXd> profiles, shifted;
  for (const RegisteredCase* one : cases) {
    const ProfileImage image(one->data->image, one->seed_mm, kProfileImageRadius * size, model, run);
    profiles.push_back(profiles_at(image, shape.mean.neighbours, one->points, model.step_mm, 0));
    if (count < kFewCases)
      for (const double shift : {-1.0, 1.0})
        shifted.push_back(profiles_at(image, shape.mean.neighbours, one->points, model.step_mm, shift));
  }
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(profiles[0].rows(), kSamples);
  for (const Eigen::MatrixXd& one : profiles) mean += one / count;
  std::vector<Covariance> covariances(vertices, Covariance::Zero());
  for (std::size_t v = 0; v < vertices; ++v) {
    for (int c = 0; c < count; ++c) {
      const Eigen::RowVectorXd d = profiles[c].row(v) - mean.row(v);
      covariances[v] += d.transpose() * d / std::max(count - 1, 1);
    }
    for (std::size_t s = 0; s < shifted.size(); ++s) {
      const Eigen::RowVectorXd d = shifted[s].row(v) - profiles[s / 2].row(v);
      covariances[v] += d.transpose() * d / static_cast<double>(shifted.size());
    }
  }
  for (int k = 0; k < kCovarianceSmoothings; ++k) {
    const std::vector<Covariance> old = covariances;
    for (std::size_t v = 0; v < vertices; ++v) {
      for (const int u : shape.mean.neighbours[v]) covariances[v] += old[u];
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

OrganModel train_on(const SimplexMesh& mesh, const std::vector<const RegisteredCase*>& cases,
                    const TrainingSettings& settings, const RunJobs& run) {
  OrganModel model;
  model.shape = train_shape(mesh, cases, settings.modes);
  model.profiles = train_profiles(model.shape, cases, settings.scale, run);
  return model;
}

/// Fits models to cases that they have not seen.
void cross_validate(const RegisteredCases& registered, const TrainingSettings& settings, const RunJobs& run,
                    OrganModel& model) {
  const auto count = static_cast<int>(registered.cases.size());
  model.surface_error_mm = kUnknownError * size_of(model.shape);
  if (count < 2) return;
  const int folds = std::min(kFolds, count);
  double squares = 0;
  std::size_t vertices = 0;
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<const RegisteredCase*> others;
    for (int c = 0; c < count; ++c)
      if (c % folds != fold) others.push_back(&registered.cases[c]);
    const OrganModel without = train_on(registered.mesh, others, settings, run);
    for (int c = fold; c < count; c += folds) {
      const RegisteredCase& one = registered.cases[c];
      ModelFitter fitter(without, one.data->image, run);
      const Mark seed{MarkKind::Inside, one.seed_mm, one.radius_mm};
      const ModelFit fit = fitter.fit({&seed, 1});
      const Points normals = normals_of(registered.mesh.neighbours, fit.points);
      for (Eigen::Index v = 0; v < fit.points.cols(); ++v)
        squares += std::pow(normals.col(v).dot(one.points.col(v) - fit.points.col(v)), 2);
      vertices += fit.points.cols();
    }
  }
  model.surface_error_mm = std::sqrt(squares / static_cast<double>(vertices));
}

/// Largest part of a mask that is smoothed by a Gaussian, without cavities.
Mask smoothed_mask(const Mask& mask, double voxels) {
  Mask result = mask;
  VoxelBox box = bounding_box(mask, mask);
  const int margin = static_cast<int>(std::ceil(3 * voxels));
  for (int a = 0; a < 3; ++a) {
    const int last = std::min(box.first[a] + box.size[a] + margin, mask.geometry.size[a]);
    box.first[a] = std::max(box.first[a] - margin, 0);
    box.size[a] = last - box.first[a];
  }
  std::vector<float> values(box.voxel_count());
  const auto each = [&](const auto& visit) {
    for (int k = 0; k < box.size[2]; ++k)
      for (int j = 0; j < box.size[1]; ++j)
        for (int i = 0; i < box.size[0]; ++i) {
          const auto [ni, nj, nk] = mask.geometry.size;
          visit(values[box.offset(i, j, k)],
                result.voxels[(std::size_t(box.first[2] + k) * nj + box.first[1] + j) * ni + box.first[0] + i]);
        }
  };
  each([](float& value, std::uint8_t voxel) { value = voxel; });
  smooth_gaussian(values, box, {voxels, voxels, voxels});
  each([](const float& value, std::uint8_t& voxel) { voxel = value > 0.5f; });
  fill_cavities(result, result.voxels.size());
  return largest_part(result);
}

/// Template from the object of a case. `vertices`: TrainingSettings::vertices.
SimplexMesh template_of(const Mask& object, int vertices) {
  if (vertices == 0) {
    const SimplexMesh coarse = mesh_of_mask(object, kLeastVertices);
    const double edges =
        mean_edge_mm(coarse.positions, coarse.neighbours) / (kLargestEdge * deepest_voxel(object)->depth_mm);
    vertices =
        static_cast<int>(std::clamp(kLeastVertices * edges * edges, double(kLeastVertices), double(kMostVertices)));
  }
  SimplexMesh mesh;
  for (const double voxels : kTemplateSmoothing) {
    const Mask mask = voxels > 0 ? smoothed_mask(object, voxels) : object;
    if (std::ranges::find(mask.voxels, std::uint8_t{1}) == mask.voxels.end()) break;
    mesh = mesh_of_mask(mask, vertices);
    if (folded_vertices(mesh) <= kMostFolded * mesh.vertex_count()) break;
  }
  return mesh;
}

/// Mean distance of the vertices of a mesh to the nearest vertices of another, mm.
double mean_distance(const Points& from, const Points& to) {
  double sum = 0;
  for (Eigen::Index p = 0; p < from.cols(); ++p)
    sum += std::sqrt((to.colwise() - from.col(p)).colwise().squaredNorm().minCoeff());
  return sum / static_cast<double>(from.cols());
}

}  // namespace

RegisteredCases register_cases(const std::vector<ModelCase>& cases, const TrainingSettings& settings,
                               const RunJobs& run) {
  if (cases.empty()) throw Error("the table of cases", "has no case", "add a case");
  std::vector<std::pair<double, std::size_t>> volumes;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    const auto voxels = std::ranges::count(cases[c].object.voxels, std::uint8_t{1});
    if (voxels == 0) throw Error(cases[c].name, "its object is empty", "check the label and the mask");
    volumes.emplace_back(static_cast<double>(voxels) * cases[c].object.geometry.spacing_mm.prod(), c);
  }
  std::ranges::sort(volumes);
  RegisteredCases result;
  result.mesh = template_of(largest_part(cases[volumes[volumes.size() / 2].second].object), settings.vertices);
  result.cases.resize(cases.size());
  run(static_cast<int>(cases.size()), [&](int c) {
    const Mask object = largest_part(cases[c].object);
    const SimplexMesh surface = mesh_of_mask(object, kSurfaceDensity * result.mesh.vertex_count());
    const auto deepest = deepest_voxel(object);
    RegisteredCase& one = result.cases[c];
    one.data = &cases[c];
    one.points = register_template(result.mesh, surface);
    const auto [i, j, k] = deepest->voxel;
    one.seed_mm = object.geometry.world_from_index() * Eigen::Vector3d(i, j, k);
    one.radius_mm = deepest->depth_mm;
    one.folded = folded_vertices(mesh_at(result.mesh, one.points));
    const Points there = points_of(surface);
    one.distance_mm = 0.5 * (mean_distance(one.points, there) + mean_distance(there, one.points));
  });
  return result;
}

OrganModel train_model(const RegisteredCases& registered, const TrainingSettings& settings, const RunJobs& run) {
  std::vector<const RegisteredCase*> all;
  for (const RegisteredCase& one : registered.cases) all.push_back(&one);
  OrganModel model = train_on(registered.mesh, all, settings, run);
  cross_validate(registered, settings, run, model);
  for (const RegisteredCase& one : registered.cases) model.sources.push_back(one.data->source);
  return model;
}

}  // namespace simplexseg
