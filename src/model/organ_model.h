// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "image/volume.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Mean and standard deviation.
struct Normal {
  double mean = 0, deviation = 1;
};
/// Independent normal distributions of three coordinates.
struct Normal3 {
  Eigen::Vector3d mean{0, 0, 0}, deviation{1, 1, 1};
};

/// Distribution of the poses of an organ: of the similarity from the mean shape to the organ.
struct PosePrior {
  Normal log_scale;
  Normal3 rotation;                    ///< rotation vector, radians
  Normal3 from_seed;                   ///< shift minus the deepest place of the organ, where users seed it, mm
  Normal3 from_centre;                 ///< shift minus the centre of the volume, mm
  Normal log_radius;                   ///< logarithm of the depth of that place, mm, minus log_scale
  Eigen::Vector3d extent_mm{0, 0, 0};  ///< mean extent of the volumes; `from_centre` holds for similar ones only
};

/// Low-rank Gaussian distribution of shapes after similarity alignment: mean + modes b, with b normally distributed
/// with deviation 1. The modes contain the principal components of the training cases and a Gaussian process of smooth
/// deformations, for shapes that few cases cannot show. Source: Luethi et al. 2018, Gaussian process morphable models.
struct ShapeModel {
  SimplexMesh mean;       ///< V vertices, centred at 0, mm
  Eigen::MatrixXf modes;  ///< 3 V x K; rows 3 v + a: coordinate a of vertex v; columns in order of decreasing variance
  PosePrior pose;

  int vertex_count() const { return mean.vertex_count(); }
  int mode_count() const { return static_cast<int>(modes.cols()); }
};

/// How the intensities of images are made comparable.
enum class IntensityScale : std::uint8_t {
  Percentiles,  ///< 0 at the 2nd percentile of the surroundings, 1 at the 98th
  Hounsfield,   ///< CT: multiples of 500 HU
};

/// Intensity profiles along the normal of each vertex: mean and covariance of kSamples samples, from inside outwards.
/// Source: Cootes et al. 1995, Active shape models - their training and application.
struct ProfileModel {
  static constexpr int kHalf = 9;  ///< samples on each side of the surface
  static constexpr int kSamples = 2 * kHalf + 1;
  static constexpr int kWhitening = kSamples * (kSamples + 1) / 2;

  IntensityScale scale = IntensityScale::Percentiles;
  double step_mm = 1;  ///< distance of samples
  double cell_mm = 0;  ///< mean of the smallest voxel spacings of the training images; finer images are averaged
  double surroundings_mm = 1;  ///< half edge of the box around the organ that determines the percentiles
  std::vector<float> mean;     ///< V x kSamples
  /// V x kWhitening: lower triangle, row by row, of the inverse of the Cholesky factor of the covariance.
  std::vector<float> whitening;
};

/// Case that a model was trained on. No image.
struct TrainedCase {
  static constexpr int kMargin = 1;  ///< samples of a profile beyond those of ProfileModel, on each side
  static constexpr int kStored = ProfileModel::kSamples + 2 * kMargin;

  /// Checksums of the voxels of image and labels.
  struct Source {
    std::string image, labels;
  };
  Source source;
  int image_number = 0;                ///< cases of several organs with equal numbers were in one image
  Eigen::Matrix3Xd points;             ///< vertices of the registered template, mm; empty: not stored
  std::vector<float> profiles;         ///< V x kStored, sampled as those of the model
  Eigen::Vector3d seed_mm{0, 0, 0};    ///< deepest place of the organ
  double radius_mm = 0;                ///< its depth
  Eigen::Vector3d centre_mm{0, 0, 0};  ///< of the volume
  Eigen::Vector3d extent_mm{0, 0, 0};  ///< of the volume, as PosePrior::extent_mm
  double error_mm = 0;                 ///< error of the instance of a model that had not seen the case
  int error_cases = 0;                 ///< number of cases of that model; 0: there was none
};

/// Error of a model on a case that it had not seen.
struct UnseenError {
  int cases = 0;        ///< number of cases of the model
  double error_mm = 0;  ///< as TrainedCase::error_mm
};

/// Statistics of the organ of one label in training cases.
struct OrganModel {
  std::string name;
  std::string modality;  ///< for example "CT"; "": not given
  ShapeModel shape;
  ProfileModel profiles;
  double surface_error_mm = 0;     ///< root mean square normal distance of fitted from correct surfaces
  std::vector<TrainedCase> cases;  ///< in the order of training
  /// Further errors of models of fewer cases on unseen cases (TrainingSettings::measure_curve); see learning_curve().
  std::vector<UnseenError> curve;
};

/// Extents of a volume along the axes of the patient, mm, as in PosePrior::extent_mm.
Eigen::Vector3d extent_mm(const VolumeGeometry& volume);

/// Whether a volume has an extent similar to those of the training, so that PosePrior::from_centre holds.
bool has_similar_extent(const PosePrior& pose, const VolumeGeometry& volume);

/// Mean shape deformed by all modes, one point per column, mm. `coefficients`: of each mode, deviations.
Eigen::Matrix3Xd shape_of(const ShapeModel& shape, const Eigen::VectorXd& coefficients);
/// Variance of each mode, summed over all coordinates, mm^2.
Eigen::VectorXd mode_variances(const ShapeModel& shape);

/// Root mean square distance of centred points, one per column, from the centre, mm: the size of a shape.
double size_of(const Eigen::Matrix3Xd& centred);
double size_of(const ShapeModel& shape);

}  // namespace simplexseg
