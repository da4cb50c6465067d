// SPDX-License-Identifier: Apache-2.0
#include "register/displacement_registration.h"

#include <itkAffineTransform.h>
#include <itkCompositeTransform.h>
#include <itkDisplacementFieldTransform.h>
#include <itkDisplacementFieldTransformParametersAdaptor.h>
#include <itkMattesMutualInformationImageToImageMetricv4.h>
#include <itkMeanSquaresImageToImageMetricv4.h>
#include <itkResampleImageFilter.h>
#include <itkShrinkImageFilter.h>
#include <itkSyNImageRegistrationMethod.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "register/mutual_information.h"

namespace simplexseg::in_register {
namespace {

using FieldTransform = itk::DisplacementFieldTransform<double, 3>;
using Field = FieldTransform::DisplacementFieldType;
using Registration = itk::SyNImageRegistrationMethod<FloatImage, FloatImage, FieldTransform>;
using Adaptor = itk::DisplacementFieldTransformParametersAdaptor<FieldTransform>;

/// Metric in a fixed number of parts, whose histograms are added in a fixed order, so that its bits do not depend on
/// the number of threads.
class Information : public itk::MattesMutualInformationImageToImageMetricv4<FloatImage, FloatImage> {
 public:
  using Self = Information;
  using Pointer = itk::SmartPointer<Self>;
  itkNewMacro(Self);

 protected:
  Information() { m_DenseGetValueAndDerivativeThreader->SetNumberOfWorkUnits(16); }
};

using Metric = itk::ImageToImageMetricv4<FloatImage, FloatImage>;

Metric::Pointer make_metric(FieldMetric kind) {
  constexpr unsigned bins = 32;  // of the histogram of each image
  Metric::Pointer metric;
  if (kind == FieldMetric::MutualInformation) {
    const auto information = Information::New();
    information->SetNumberOfHistogramBins(bins);
    metric = information;
  } else {
    metric = itk::MeanSquaresImageToImageMetricv4<FloatImage, FloatImage>::New();
  }
  metric->SetUseMovingImageGradientFilter(false);
  metric->SetUseFixedImageGradientFilter(false);
  return metric;
}

/// Grid with voxels of equal sides where the slices of an image are thick: along axes with a spacing above 1.5
/// `spacing_mm` there are more voxels.
ImageHead grid_with_equal_sides(const FloatImage& image, double spacing_mm) {
  constexpr double thick = 1.5;
  ImageHead grid = head_of(image);
  for (unsigned a = 0; a < 3; ++a) {
    if (grid.size[a] < 2 || grid.spacing_mm[a] <= thick * spacing_mm) continue;
    const double length_mm = grid.spacing_mm[a] * (grid.size[a] - 1);
    const int intervals = std::max(1, static_cast<int>(std::round(length_mm / spacing_mm)));
    grid.size[a] = intervals + 1;
    grid.spacing_mm[a] = length_mm / intervals;
  }
  return grid;
}

double voxel_count(const ImageHead& grid) { return 1.0 * grid.size[0] * grid.size[1] * grid.size[2]; }

/// Image with interpolated voxels on that grid.
FloatImage::Pointer with_equal_sides(const FloatImage::Pointer& image, double spacing_mm) {
  const ImageHead grid = grid_with_equal_sides(*image, spacing_mm);
  if (grid.size == head_of(*image).size) return image;
  const auto resampling = itk::ResampleImageFilter<FloatImage, FloatImage>::New();
  resampling->SetInput(image);
  resampling->SetReferenceImage(make_image(grid));
  resampling->SetUseReferenceImage(true);
  resampling->Update();
  return resampling->GetOutput();
}

constexpr double kMaxVoxels = 1000000;  // of the grid of the field
constexpr unsigned kLevels = 3;
constexpr std::array<int, kLevels> kIterations{60, 40, 5};
constexpr std::array<unsigned, kLevels> kShrink{4, 2, 1};
constexpr std::array<double, kLevels> kSigma{2, 1, 0};  // voxels
constexpr double kStep = 0.4;                           // largest displacement of an iteration, voxels
constexpr double kUpdateVariance = 8;                   // of the Gaussian that smooths an update, voxels squared

itk::AffineTransform<double, 3>::Pointer itk_affine(const Eigen::Affine3d& affine) {
  const auto result = itk::AffineTransform<double, 3>::New();
  itk::AffineTransform<double, 3>::MatrixType matrix;
  itk::AffineTransform<double, 3>::OutputVectorType offset;
  for (unsigned a = 0; a < 3; ++a) {
    for (unsigned b = 0; b < 3; ++b) matrix(a, b) = affine.linear()(a, b);
    offset[a] = affine.translation()[a];
  }
  result->SetMatrix(matrix);
  result->SetOffset(offset);
  return result;
}

/// Field of zeros on the grid of an image.
Field::Pointer make_field(const FloatImage* image) {
  const auto field = Field::New();
  field->CopyInformation(image);
  field->SetRegions(image->GetBufferedRegion());
  field->Allocate();
  field->FillBuffer(Field::PixelType(0.0));
  return field;
}

/// Appends the vectors of a field on its grid with one more voxel at each side, which repeats the border: ITK shrinks a
/// grid inwards, and a field is 0 outside its grid.
void append_padded(const Field* field, RegistrationResponse& found) {
  const auto size = field->GetLargestPossibleRegion().GetSize();
  ImageHead& head = found.field;
  Eigen::Vector3d first = Eigen::Vector3d::Constant(-1);
  for (unsigned a = 0; a < 3; ++a) {
    head.size[a] = static_cast<int>(size[a]) + 2;
    head.spacing_mm[a] = field->GetSpacing()[a];
    head.origin_mm[a] = field->GetOrigin()[a];
    for (unsigned b = 0; b < 3; ++b) head.direction(a, b) = field->GetDirection()(a, b);
  }
  head.origin_mm = geometry_of(head).world_from_index() * first;
  const auto inside = [&](int index, unsigned axis) {
    return std::clamp<itk::IndexValueType>(index - 1, 0, static_cast<itk::IndexValueType>(size[axis]) - 1);
  };
  found.vectors.reserve(3 * geometry_of(head).voxel_count());
  for (int k = 0; k < head.size[2]; ++k) {
    for (int j = 0; j < head.size[1]; ++j) {
      for (int i = 0; i < head.size[0]; ++i) {
        const Field::PixelType& vector = field->GetPixel({{inside(i, 0), inside(j, 1), inside(k, 2)}});
        for (unsigned a = 0; a < 3; ++a) found.vectors.push_back(static_cast<float>(vector[a]));
      }
    }
  }
}

}  // namespace

void add_displacements(const FloatImage* fixed, const FloatImage* moving, FieldMetric metric,
                       const Eigen::Affine3d& affine, double done, ProgressSender& progress,
                       RegistrationResponse& found) {
  FloatImage::Pointer coarse_fixed = coarsen(fixed, 0);
  double spacing = geometry_of(head_of(*fixed)).spacing_mm.minCoeff();
  while (voxel_count(grid_with_equal_sides(*coarse_fixed, spacing)) > kMaxVoxels)
    coarse_fixed = coarsen(coarse_fixed, spacing *= 2);
  coarse_fixed = with_equal_sides(coarse_fixed, spacing);
  const FloatImage::Pointer coarse_moving = with_equal_sides(coarsen(moving, spacing), spacing);
  const auto linear = itk_affine(affine);
  const auto registration = Registration::New();
  registration->SetFixedImage(coarse_fixed);
  registration->SetMovingImage(coarse_moving);
  registration->SetMovingInitialTransform(linear);
  const auto start = FieldTransform::New();
  start->SetDisplacementField(make_field(coarse_fixed));
  start->SetInverseDisplacementField(make_field(coarse_fixed));
  registration->SetInitialTransform(start);
  registration->InPlaceOn();
  registration->SetMetric(make_metric(metric));
  registration->SetNumberOfLevels(kLevels);
  Registration::ShrinkFactorsArrayType shrink(kLevels);
  Registration::SmoothingSigmasArrayType sigmas(kLevels);
  Registration::NumberOfIterationsArrayType iterations(kLevels);
  Registration::TransformParametersAdaptorsContainerType adaptors;
  for (unsigned level = 0; level < kLevels; ++level) {
    shrink[level] = kShrink[level];
    sigmas[level] = kSigma[level];
    iterations[level] = static_cast<itk::SizeValueType>(kIterations[level]);
    const auto grid = itk::ShrinkImageFilter<FloatImage, FloatImage>::New();
    grid->SetInput(coarse_fixed);
    grid->SetShrinkFactors(kShrink[level]);
    grid->Update();
    const auto adaptor = Adaptor::New();
    adaptor->SetRequiredSpacing(grid->GetOutput()->GetSpacing());
    adaptor->SetRequiredSize(grid->GetOutput()->GetBufferedRegion().GetSize());
    adaptor->SetRequiredDirection(grid->GetOutput()->GetDirection());
    adaptor->SetRequiredOrigin(grid->GetOutput()->GetOrigin());
    adaptors.push_back(adaptor.GetPointer());
  }
  registration->SetShrinkFactorsPerLevel(shrink);
  registration->SetSmoothingSigmasPerLevel(sigmas);
  registration->SetSmoothingSigmasAreSpecifiedInPhysicalUnits(false);
  registration->SetNumberOfIterationsPerLevel(iterations);
  registration->SetTransformParametersAdaptorsPerLevel(adaptors);
  registration->SetLearningRate(kStep);
  registration->SetGaussianSmoothingVarianceForTheUpdateField(kUpdateVariance);
  registration->SetGaussianSmoothingVarianceForTheTotalField(0);
  // All iterations run, because the value that would end them is a sum over threads.
  registration->SetConvergenceThreshold(-1e9);
  registration->SetDownsampleImagesForMetricDerivatives(true);
  int iteration = 0;
  double cost = 0, total = 0;  // an iteration costs in proportion to its voxels
  const auto cost_at = [](unsigned level) { return 1.0 / (kShrink[level] * kShrink[level] * kShrink[level]); };
  for (unsigned level = 0; level < kLevels; ++level) total += kIterations[level] * cost_at(level);
  registration->AddObserver(itk::IterationEvent(), [&](const itk::EventObject&) {
    const auto level = std::min<unsigned>(static_cast<unsigned>(registration->GetCurrentLevel()), kLevels - 1);
    cost += cost_at(level);
    progress.send({"displacement", spacing * kShrink[level], ++iteration, registration->GetCurrentMetricValue(),
                   done + (1 - done) * std::min(1.0, cost / total)});
  });
  registration->Update();
  const FieldTransform* const transform = registration->GetTransform();
  append_padded(transform->GetDisplacementField(), found);
  const auto both = itk::CompositeTransform<double, 3>::New();
  both->AddTransform(linear);
  both->AddTransform(registration->GetModifiableTransform());  // acts first
  const auto warped = itk::ResampleImageFilter<FloatImage, FloatImage>::New();
  warped->SetInput(moving);
  warped->SetTransform(both);
  warped->SetReferenceImage(fixed);
  warped->SetUseReferenceImage(true);
  warped->Update();
  found.metric_after =
      MutualInformation(fixed, warped->GetOutput(), LinearKind::Affine, kFineMetric).value(Eigen::Affine3d::Identity());
  found.levels.push_back({"displacement", spacing, iteration, found.metric_after});
}

}  // namespace simplexseg::in_register
