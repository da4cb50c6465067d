// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "field/marks.h"
#include "field/run_jobs.h"
#include "image/volume.h"
#include "model/organ_model.h"
#include "model/pose_relations.h"
#include "model/profile_image.h"

namespace simplexseg {

/// Instance of a model in an image.
struct ModelFit {
  Eigen::Matrix3Xd points;     ///< vertices, mm
  double cost = 0;             ///< mean squared Mahalanobis distance of the profiles per sample, at most 9 each
  double size_deviations = 0;  ///< difference of the radius of the seed from that of the model, deviations
};

/// Fits a model to an image: the most probable pose and modes, given profiles, marks and the distributions of the
/// model.
///
/// Each iteration finds for each vertex the expected shift along its normal and its variance from the costs of its
/// profile at shifts of up to kShifts samples, and solves the linearised normal equations of pose and modes. Marks are
/// further observations: a surface passes boundary marks, and balls are on their side of it. Vertices outside the
/// volume have no profile. The iteration starts at the mean shape in several orientations, and at several shifts for a
/// seed that is not in the deepest place, for example because the volume cuts the organ; the instance with the least
/// energy is kept. Results have equal bits for any number of threads and depend on the marks alone. Source: Cootes et
/// al. 1995 (search along normals), Luethi et al. 2018 (posterior of a Gaussian shape model).
class ModelFitter {
 public:
  /// The arguments must outlive the fitter.
  ModelFitter(const OrganModel& model, const Volume& volume, RunJobs run);

  /// Instance for these marks. Without an inside mark, the start is at the mean place relative to the volume.
  ModelFit fit(std::span<const Mark> marks);

  /// Instance whose pose has this distribution, for example because other organs are found. Nothing if the most
  /// probable instance is at a place that is improbable under it.
  std::optional<ModelFit> fit_at(const PoseDistribution& expected);

 private:
  struct Prior;
  struct State;
  /// `anywhere`: for a seed that is not in the deepest place of the organ.
  Prior prior_of(const Mark* seed, bool anywhere) const;
  void prepare(const Mark* seed);
  State start_of(const Prior& prior, const Eigen::Vector3d& turn) const;
  Eigen::Matrix3Xd points_at(const State& state) const;
  /// Whether a place is on the inner side of the surface, at its nearest vertex.
  bool is_inside(const State& state, const Eigen::Vector3d& place) const;
  void iterate(State& state, const Prior& prior, std::span<const Mark> marks, int stride, double widest) const;
  /// Negative logarithm of the posterior, up to a constant. `cost`: receives ModelFit::cost; may be null.
  double energy_of(const State& state, const Prior& prior, int stride, double* cost) const;

  const OrganModel& model_;
  const Volume& volume_;
  RunJobs run_;
  std::optional<ProfileImage> image_;
  std::optional<Mark> seed_;        // of image_ and of_seed_
  std::shared_ptr<State> of_seed_;  // instance for the seed alone
  bool anywhere_ = false;           // prior_of() of that instance
};

}  // namespace simplexseg
