// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <memory>

#include "register/itk_image.h"

namespace simplexseg::in_register {

enum class LinearKind { Rigid, Affine };

struct MetricSettings {
  int samples = 0;      ///< number of points in the fixed image
  int bins = 0;         ///< of the histogram of each image
  int evaluations = 0;  ///< largest number of evaluations of an optimisation
};
inline constexpr MetricSettings kSearchMetric{4000, 24, 25};
inline constexpr MetricSettings kCoarseMetric{30000, 32, 40};
inline constexpr MetricSettings kFineMetric{100000, 40, 40};

struct Fit {
  Eigen::Affine3d map = Eigen::Affine3d::Identity();
  double value = 0;
  int iterations = 0;
};

/// Negative mutual information of two images in normalised coordinates at fixed samples, as a function of a rigid or
/// affine map (itk::MattesMutualInformationImageToImageMetricv4). Functions throw itk::ExceptionObject, a
/// std::exception, when too few samples lie in the moving image. Results depend on the arguments only, bit by bit.
class MutualInformation {
 public:
  MutualInformation(const FloatImage* fixed, const FloatImage* moving, LinearKind kind, const MetricSettings& settings);
  ~MutualInformation();
  MutualInformation(const MutualInformation&) = delete;
  MutualInformation& operator=(const MutualInformation&) = delete;

  double value(const Eigen::Affine3d& map);
  /// Minimises the value by L-BFGS. `on_iteration` receives the number of the iteration and the value.
  Fit optimise(const Eigen::Affine3d& start, const std::function<void(int, double)>& on_iteration);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace simplexseg::in_register
