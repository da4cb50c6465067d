// SPDX-License-Identifier: Apache-2.0
#include "register/mutual_information.h"

#include <itkAffineTransform.h>
#include <itkEuler3DTransform.h>
#include <itkLBFGSOptimizerv4.h>
#include <itkMattesMutualInformationImageToImageMetricv4.h>

#include <algorithm>
#include <cstdint>
#include <random>

namespace simplexseg::in_register {
namespace {

/// Metric that is computed by one thread. ITK adds the derivatives of several threads in the order in which they end,
/// so that their last bits vary; SetMaximumNumberOfWorkUnits() of ITK 5.2 has no effect on it.
class Metric : public itk::MattesMutualInformationImageToImageMetricv4<FloatImage, FloatImage> {
 public:
  using Self = Metric;
  using Pointer = itk::SmartPointer<Self>;
  itkNewMacro(Self);

 protected:
  Metric() {
    m_SparseGetValueAndDerivativeThreader->SetNumberOfWorkUnits(1);
    m_DenseGetValueAndDerivativeThreader->SetNumberOfWorkUnits(1);
  }
};

using Optimizer = itk::LBFGSOptimizerv4;
using LinearTransform = itk::MatrixOffsetTransformBase<double, 3, 3>;

/// Samples in strata of equal size along the voxels, each moved by up to half a voxel, which prevents artefacts of
/// interpolation at equal grids (Thévenaz 2008).
Metric::FixedSampledPointSetType::Pointer make_samples(const FloatImage* image, int wanted) {
  const auto size = image->GetLargestPossibleRegion().GetSize();
  const std::uint64_t voxels = size[0] * size[1] * size[2];
  const std::uint64_t count = std::min<std::uint64_t>(voxels, static_cast<std::uint64_t>(wanted));
  std::mt19937_64 bits(20031126);
  const auto share = [&] { return static_cast<double>(bits() >> 11) * 0x1p-53; };
  const auto points = Metric::FixedSampledPointSetType::New();
  for (std::uint64_t n = 0; n < count; ++n) {
    const auto voxel =
        std::min(voxels - 1, static_cast<std::uint64_t>((static_cast<double>(n) + share()) *
                                                        static_cast<double>(voxels) / static_cast<double>(count)));
    itk::ContinuousIndex<double, 3> index;
    index[0] = static_cast<double>(voxel % size[0]) + share() - 0.5;
    index[1] = static_cast<double>(voxel / size[0] % size[1]) + share() - 0.5;
    index[2] = static_cast<double>(voxel / size[0] / size[1]) + share() - 0.5;
    FloatImage::PointType world;
    image->TransformContinuousIndexToPhysicalPoint(index, world);
    Metric::FixedSampledPointSetType::PointType point;
    for (unsigned a = 0; a < 3; ++a) point[a] = static_cast<Metric::FixedSampledPointSetType::CoordRepType>(world[a]);
    points->SetPoint(n, point);
  }
  return points;
}

}  // namespace

struct MutualInformation::Parts {
  Metric::Pointer metric = Metric::New();
  LinearTransform::Pointer transform;
  int evaluations = 0;

  void set(const Eigen::Affine3d& map) {
    LinearTransform::MatrixType matrix;
    LinearTransform::OutputVectorType offset;
    for (unsigned a = 0; a < 3; ++a) {
      for (unsigned b = 0; b < 3; ++b) matrix(a, b) = map.linear()(a, b);
      offset[a] = map.translation()[a];
    }
    transform->SetMatrix(matrix);  // the centre is 0, so the translation is the offset
    transform->SetOffset(offset);
  }
  Eigen::Affine3d map() const {
    Eigen::Affine3d result = Eigen::Affine3d::Identity();
    for (unsigned a = 0; a < 3; ++a) {
      for (unsigned b = 0; b < 3; ++b) result.linear()(a, b) = transform->GetMatrix()(a, b);
      result.translation()[a] = transform->GetOffset()[a];
    }
    return result;
  }
};

MutualInformation::MutualInformation(const FloatImage* fixed, const FloatImage* moving, LinearKind kind,
                                     const MetricSettings& settings)
    : parts_(std::make_unique<Parts>()) {
  Metric& metric = *parts_->metric;
  parts_->evaluations = settings.evaluations;
  if (kind == LinearKind::Rigid) {
    parts_->transform = itk::Euler3DTransform<double>::New();
  } else {
    parts_->transform = itk::AffineTransform<double, 3>::New();
  }
  metric.SetFixedImage(fixed);
  metric.SetMovingImage(moving);
  metric.SetMovingTransform(parts_->transform);
  metric.SetNumberOfHistogramBins(static_cast<itk::SizeValueType>(settings.bins));
  metric.SetUseMovingImageGradientFilter(false);
  metric.SetUseFixedImageGradientFilter(false);
  metric.SetFixedSampledPointSet(make_samples(fixed, settings.samples));
  metric.SetUseSampledPointSet(true);
  metric.Initialize();
}

MutualInformation::~MutualInformation() = default;

double MutualInformation::value(const Eigen::Affine3d& map) {
  parts_->set(map);
  return parts_->metric->GetValue();
}

Fit MutualInformation::optimise(const Eigen::Affine3d& start, const std::function<void(int, double)>& on_iteration) {
  parts_->set(start);
  const auto optimizer = Optimizer::New();
  optimizer->SetMetric(parts_->metric);
  optimizer->SetNumberOfIterations(static_cast<itk::SizeValueType>(parts_->evaluations));
  optimizer->SetMaximumNumberOfFunctionEvaluations(static_cast<unsigned>(parts_->evaluations));
  optimizer->SetDefaultStepLength(0.02);  // of the radius of the image
  optimizer->SetGradientConvergenceTolerance(1e-4);
  optimizer->AddObserver(itk::IterationEvent(), [&](const itk::EventObject&) {
    on_iteration(static_cast<int>(optimizer->GetCurrentIteration()), optimizer->GetCurrentMetricValue());
  });
  optimizer->StartOptimization();
  return {parts_->map(), parts_->metric->GetValue(), static_cast<int>(optimizer->GetCurrentIteration())};
}

}  // namespace simplexseg::in_register
