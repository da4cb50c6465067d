// SPDX-License-Identifier: Apache-2.0
#include "model/model_training.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"
#include "field/robot_user.h"
#include "image/gaussian.h"
#include "image/label_surface.h"
#include "mesh/mesh_geometry.h"
#include "model/model_fit.h"
#include "model/model_statistics.h"
#include "model/profile_image.h"
#include "model/template_registration.h"

namespace simplexseg {
namespace {

constexpr int kSurfaceDensity = 4;  ///< vertices of the surface of a case per vertex of the template
/// Standard deviations of the Gaussians that simplify the mask of a template, voxels: the first with few folds is used.
constexpr std::array kTemplateSmoothing{0.0, 0.7, 1.0, 1.5};
constexpr double kMostFolded = 0.02;                        ///< share of folded vertices of a template
constexpr int kLeastVertices = 1000, kMostVertices = 2500;  ///< of a template, unless the number is given
constexpr double kLargestEdge = 0.35;                       ///< mean edge of a template, depths of the object
constexpr double kSamplesPerSize = 28;                      ///< profile samples per size
constexpr double kSurroundings = 1.6;                       ///< ProfileModel::surroundings_mm, sizes
constexpr int kCurveTests = 10;         ///< largest number of unseen cases for each number of training cases of a curve
constexpr int kFolds = 5;               ///< of the cross-validation
constexpr double kUnknownError = 0.06;  ///< surface_error_mm without cross-validation, sizes

using Points = Eigen::Matrix3Xd;

/// Case as the statistics need it, without profiles.
TrainedCase trained_case(const RegisteredCase& one) {
  const VolumeGeometry& grid = one.data->image.geometry();
  TrainedCase result;
  result.source = one.data->source;
  result.image_number = one.data->image_number;
  result.points = one.points;
  result.seed_mm = one.seed_mm, result.radius_mm = one.radius_mm;
  result.centre_mm = grid.centre_mm(), result.extent_mm = extent_mm(grid);
  return result;
}

/// Profiles of a case as TrainedCase::profiles. `size`: of the mean shape.
std::vector<float> profiles_of(const RegisteredCase& one, const std::vector<std::array<int, 3>>& neighbours,
                               const ProfileModel& sampling, double size, const RunJobs& run) {
  const ProfileImage image(one.data->image, one.seed_mm, kProfileImageRadius * size, sampling, run);
  const Points normals = normals_of(neighbours, one.points);
  constexpr int kMiddle = ProfileModel::kHalf + TrainedCase::kMargin;
  std::vector<float> profiles;
  profiles.reserve(static_cast<std::size_t>(one.points.cols()) * TrainedCase::kStored);
  for (Eigen::Index v = 0; v < one.points.cols(); ++v)
    for (int s = 0; s < TrainedCase::kStored; ++s)
      profiles.push_back(image.sample(one.points.col(v) + (s - kMiddle) * sampling.step_mm * normals.col(v)));
  return profiles;
}

/// Sampling of profiles for a mean shape.
ProfileModel sampling_for(double size, const std::vector<const RegisteredCase*>& cases, IntensityScale scale) {
  ProfileModel sampling;
  sampling.scale = scale;
  sampling.step_mm = size / kSamplesPerSize;
  sampling.surroundings_mm = kSurroundings * size;
  const auto count = static_cast<int>(cases.size());
  for (const RegisteredCase* one : cases) sampling.cell_mm += one->data->image.geometry().spacing_mm.minCoeff() / count;
  return sampling;
}

/// Model of these cases, with their data and without its error.
OrganModel train_on(const SimplexMesh& mesh, const std::vector<const RegisteredCase*>& cases,
                    const TrainingSettings& settings, const RunJobs& run) {
  OrganModel model;
  for (const RegisteredCase* one : cases) model.cases.push_back(trained_case(*one));
  std::vector<const TrainedCase*> shapes;
  for (const TrainedCase& one : model.cases) shapes.push_back(&one);
  model.shape = train_shape(mesh.neighbours, shapes, settings.modes);
  const double size = size_of(model.shape);
  const ProfileModel sampling = sampling_for(size, cases, settings.scale);
  std::vector<const std::vector<float>*> profiles;
  for (std::size_t c = 0; c < cases.size(); ++c) {
    model.cases[c].profiles = profiles_of(*cases[c], mesh.neighbours, sampling, size, run);
    profiles.push_back(&model.cases[c].profiles);
  }
  model.profiles = train_profiles(sampling, mesh.neighbours, profiles);
  return model;
}

/// Root mean square normal distance of the instance of a model for the seed of a case from the surface of the case, mm.
double error_on(const OrganModel& model, const RegisteredCase& one, const RunJobs& run) {
  ModelFitter fitter(model, one.data->image, run);
  const Mark seed{MarkKind::Inside, one.seed_mm, one.radius_mm};
  const ModelFit fit = fitter.fit({&seed, 1});
  const Points normals = normals_of(model.shape.mean.neighbours, fit.points);
  return std::sqrt(normals.cwiseProduct(one.points - fit.points).colwise().sum().squaredNorm() /
                   static_cast<double>(fit.points.cols()));
}

/// Error of a model from those of its cases: their mean square, weighted with the number of cases of the model that had
/// not seen them.
double error_of(const OrganModel& model) {
  double squares = 0, weights = 0;
  for (const TrainedCase& one : model.cases) {
    squares += one.error_cases * one.error_mm * one.error_mm;
    weights += one.error_cases;
  }
  return weights > 0 ? std::sqrt(squares / weights) : kUnknownError * size_of(model.shape);
}

/// Errors of models on cases that they have not seen.
void cross_validate(const RegisteredCases& registered, const TrainingSettings& settings, const RunJobs& run,
                    OrganModel& model) {
  const auto count = static_cast<int>(registered.cases.size());
  if (count < 2) return;
  const int folds = std::min(kFolds, count);
  for (int fold = 0; fold < folds; ++fold) {
    std::vector<const RegisteredCase*> others;
    for (int c = 0; c < count; ++c)
      if (c % folds != fold) others.push_back(&registered.cases[c]);
    const OrganModel without = train_on(registered.mesh, others, settings, run);
    for (int c = fold; c < count; c += folds) {
      model.cases[c].error_mm = error_on(without, registered.cases[c], run);
      model.cases[c].error_cases = static_cast<int>(others.size());
    }
  }
}

/// Errors of models of 1, 2, 4, ... cases on some of the others. Both are spread evenly over the table.
std::vector<UnseenError> measure_curve(const RegisteredCases& registered, const TrainingSettings& settings,
                                       const RunJobs& run) {
  const auto count = static_cast<int>(registered.cases.size());
  std::vector<UnseenError> curve;
  for (int cases = 1; 2 * cases <= count; cases *= 2) {
    std::vector<const RegisteredCase*> seen, unseen;
    for (int c = 0; c < count; ++c) {
      const bool is_seen = (c + 1) * cases / count > c * cases / count;
      (is_seen ? seen : unseen).push_back(&registered.cases[c]);
    }
    const OrganModel model = train_on(registered.mesh, seen, settings, run);
    const int tests = std::min(kCurveTests, static_cast<int>(unseen.size()));
    for (int t = 0; t < tests; ++t) curve.push_back({cases, error_on(model, *unseen[unseen.size() * t / tests], run)});
  }
  return curve;
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

/// Registers a template to a case, whose object must not be empty.
RegisteredCase register_case(const SimplexMesh& mesh, const ModelCase& data) {
  const Mask object = largest_part(data.object);
  const SimplexMesh surface = mesh_of_mask(object, kSurfaceDensity * mesh.vertex_count());
  const auto deepest = deepest_voxel(object);
  RegisteredCase one;
  one.data = &data;
  one.points = register_template(mesh, surface);
  const auto [i, j, k] = deepest->voxel;
  one.seed_mm = object.geometry.world_from_index() * Eigen::Vector3d(i, j, k);
  one.radius_mm = deepest->depth_mm;
  one.folded = folded_vertices(mesh_at(mesh, one.points));
  const Points there = points_of(surface);
  one.distance_mm = 0.5 * (mean_distance(one.points, there) + mean_distance(there, one.points));
  return one;
}

/// Number of voxels of the object of a case. Throws Error for none.
double voxels_of(const ModelCase& one) {
  const auto voxels = std::ranges::count(one.object.voxels, std::uint8_t{1});
  if (voxels == 0) throw Error(one.name, "its object is empty", "check the label and the mask");
  return static_cast<double>(voxels);
}

}  // namespace

RegisteredCases register_cases(const std::vector<ModelCase>& cases, const TrainingSettings& settings,
                               const RunJobs& run) {
  if (cases.empty()) throw Error("the table of cases", "has no case", "add a case");
  std::vector<std::pair<double, std::size_t>> volumes;
  for (std::size_t c = 0; c < cases.size(); ++c)
    volumes.emplace_back(voxels_of(cases[c]) * cases[c].object.geometry.spacing_mm.prod(), c);
  std::ranges::sort(volumes);
  RegisteredCases result;
  result.mesh = template_of(largest_part(cases[volumes[volumes.size() / 2].second].object), settings.vertices);
  result.cases.resize(cases.size());
  run(static_cast<int>(cases.size()), [&](int c) { result.cases[c] = register_case(result.mesh, cases[c]); });
  return result;
}

OrganModel train_model(const RegisteredCases& registered, const TrainingSettings& settings, const RunJobs& run) {
  std::vector<const RegisteredCase*> all;
  for (const RegisteredCase& one : registered.cases) all.push_back(&one);
  OrganModel model = train_on(registered.mesh, all, settings, run);
  cross_validate(registered, settings, run, model);
  model.surface_error_mm = error_of(model);
  if (settings.measure_curve) model.curve = measure_curve(registered, settings, run);
  return model;
}

bool can_grow(const OrganModel& model) {
  return !model.cases.empty() && std::ranges::none_of(model.cases, [](const TrainedCase& one) {
    return one.points.cols() == 0 || one.profiles.empty();
  });
}

AddedCase add_case(const OrganModel& model, const ModelCase& added, int most_modes, const RunJobs& run) {
  if (!can_grow(model))
    throw Error("the model", "it does not contain the shapes of its cases", "train it again from its table of cases");
  voxels_of(added);
  AddedCase result;
  result.registered = register_case(model.shape.mean, added);
  const RegisteredCase& one = result.registered;
  OrganModel& larger = result.model;
  larger = model;
  TrainedCase& data = larger.cases.emplace_back(trained_case(one));
  data.error_mm = error_on(model, one, run);
  data.error_cases = static_cast<int>(model.cases.size());
  std::vector<const TrainedCase*> shapes;
  for (const TrainedCase& each : larger.cases) shapes.push_back(&each);
  const std::vector<std::array<int, 3>>& neighbours = model.shape.mean.neighbours;
  larger.shape = train_shape(neighbours, shapes, most_modes);
  data.profiles = profiles_of(one, neighbours, model.profiles, size_of(larger.shape), run);
  std::vector<const std::vector<float>*> profiles;
  for (const TrainedCase& each : larger.cases) profiles.push_back(&each.profiles);
  larger.profiles = train_profiles(model.profiles, neighbours, profiles);
  larger.surface_error_mm = error_of(larger);
  return result;
}

}  // namespace simplexseg
