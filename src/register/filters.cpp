// SPDX-License-Identifier: Apache-2.0
#include "register/filters.h"

#include <itkCurvatureAnisotropicDiffusionImageFilter.h>
#include <itkDiscreteGaussianImageFilter.h>
#include <itkMedianImageFilter.h>
#include <itkNearestNeighborExtrapolateImageFunction.h>
#include <itkResampleImageFilter.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "register/bias_field.h"

namespace simplexseg::in_register {
namespace {

/// Runs a filter and reports its progress.
FloatImage::Pointer run(itk::ImageSource<FloatImage>* filter, ProgressSender& progress) {
  filter->AddObserver(itk::ProgressEvent(), [&, filter](const itk::EventObject&) {
    progress.send({"filter", 0, 0, 0, std::clamp(static_cast<double>(filter->GetProgress()), 0.0, 1.0)});
  });
  filter->Update();
  FloatImage::Pointer result = filter->GetOutput();
  result->DisconnectPipeline();
  return result;
}

FloatImage::Pointer diffuse(const FloatImage* image, int iterations, double conductance, ProgressSender& progress) {
  const auto filter = itk::CurvatureAnisotropicDiffusionImageFilter<FloatImage, FloatImage>::New();
  filter->SetInput(image);
  filter->SetNumberOfIterations(static_cast<itk::IdentifierType>(iterations));
  filter->SetConductanceParameter(conductance);
  const auto spacing = image->GetSpacing();
  filter->SetTimeStep(std::min({spacing[0], spacing[1], spacing[2]}) / 16);  // bound of stability in three dimensions
  return run(filter, progress);
}

FloatImage::Pointer take_median(const FloatImage* image, int radius, ProgressSender& progress) {
  const auto filter = itk::MedianImageFilter<FloatImage, FloatImage>::New();
  filter->SetInput(image);
  filter->SetRadius(static_cast<itk::SizeValueType>(radius));
  return run(filter, progress);
}

/// Linear interpolation on a grid with equal spacings and the same outer faces, after a Gaussian along the axes that
/// become coarser.
FloatImage::Pointer make_isotropic(const FloatImage* image, double spacing_mm, ProgressSender& progress) {
  constexpr unsigned axes = 3;
  constexpr double most = 1e10;  // voxels
  const auto from = image->GetSpacing();
  const auto size = image->GetLargestPossibleRegion().GetSize();
  const double spacing = spacing_mm > 0 ? spacing_mm : std::min({from[0], from[1], from[2]});
  using Smoothing = itk::DiscreteGaussianImageFilter<FloatImage, FloatImage>;
  Smoothing::ArrayType variances(0.0);
  ImageHead head = head_of(*image);
  double voxels = 1;
  Eigen::Vector3d first;
  for (unsigned a = 0; a < axes; ++a) {
    const double ratio = spacing / from[a];
    if (ratio > 1) variances[a] = 0.25 * (ratio * ratio - 1);
    const double count = std::max(1.0, std::round(static_cast<double>(size[a]) / ratio));
    voxels *= count;
    head.size[a] = static_cast<int>(std::min(count, 1e9));
    head.spacing_mm[a] = spacing;
    first[a] = 0.5 * (static_cast<double>(size[a]) - count * ratio + ratio) - 0.5;  // index of the first new voxel
  }
  if (voxels > most) throw Error("cannot resample the image", "the result has too many voxels", "use a larger spacing");
  head.origin_mm = geometry_of(head_of(*image)).world_from_index() * first;
  const auto smoothing = Smoothing::New();
  smoothing->SetInput(image);
  smoothing->SetUseImageSpacing(false);
  smoothing->SetVariance(variances);
  const auto filter = itk::ResampleImageFilter<FloatImage, FloatImage>::New();
  filter->SetInput(smoothing->GetOutput());
  filter->SetExtrapolator(itk::NearestNeighborExtrapolateImageFunction<FloatImage, double>::New());
  filter->SetReferenceImage(make_image(head));
  filter->SetUseReferenceImage(true);
  return run(filter, progress);
}

}  // namespace

FilterResponse filtered(const FloatImage* image, const FilterOrder& order, ProgressSender& progress) {
  const auto whole = [&](std::size_t n) { return static_cast<int>(order.parameters.at(n)); };
  FloatImage::Pointer result;
  switch (order.kind) {
    case FilterKind::BiasField:
      result = without_bias_field(image, whole(0), whole(1), whole(2), progress);
      break;
    case FilterKind::Diffusion:
      result = diffuse(image, whole(0), order.parameters.at(1), progress);
      break;
    case FilterKind::Median:
      result = take_median(image, whole(0), progress);
      break;
    case FilterKind::Isotropic:
      result = make_isotropic(image, order.parameters.at(0), progress);
      break;
    case FilterKind::Uptake:
      throw Error("cannot apply the filter suv", "it is not a filter of ITK", "install SimplexSeg again");
  }
  const float* const voxels = result->GetBufferPointer();
  return {head_of(*result), {voxels, voxels + result->GetLargestPossibleRegion().GetNumberOfPixels()}};
}

}  // namespace simplexseg::in_register
