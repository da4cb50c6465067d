// SPDX-License-Identifier: Apache-2.0
#include "register/itk_image.h"

#include <itkDiscreteGaussianImageFilter.h>
#include <itkShrinkImageFilter.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "core/error.h"
#include "core/quantile.h"
#include "io/platform/run_worker.h"

namespace simplexseg::in_register {
namespace {

constexpr unsigned kAxes = 3;

}  // namespace

FloatImage::Pointer make_image(const ImageHead& head) {
  const auto image = FloatImage::New();
  FloatImage::SizeType size;
  FloatImage::PointType origin;
  FloatImage::SpacingType spacing;
  FloatImage::DirectionType direction;
  for (unsigned a = 0; a < kAxes; ++a) {
    size[a] = static_cast<itk::SizeValueType>(head.size[a]);
    origin[a] = head.origin_mm[a];
    spacing[a] = head.spacing_mm[a];
    for (unsigned b = 0; b < kAxes; ++b) direction(a, b) = head.direction(a, b);
  }
  image->SetRegions(size);
  image->SetOrigin(origin);
  image->SetSpacing(spacing);
  image->SetDirection(direction);
  image->Allocate();
  return image;
}

ImageHead head_of(const FloatImage& image) {
  ImageHead head;
  const FloatImage::SizeType size = image.GetLargestPossibleRegion().GetSize();
  for (unsigned a = 0; a < kAxes; ++a) {
    head.size[a] = static_cast<int>(size[a]);
    head.origin_mm[a] = image.GetOrigin()[a];
    head.spacing_mm[a] = image.GetSpacing()[a];
    for (unsigned b = 0; b < kAxes; ++b) head.direction(a, b) = image.GetDirection()(a, b);
  }
  return head;
}

FloatImage::Pointer receive_image(const ImageHead& head) {
  const FloatImage::Pointer image = make_image(head);
  float* const voxels = image->GetBufferPointer();
  const std::size_t row = static_cast<std::size_t>(head.size[0]) * static_cast<std::size_t>(head.size[1]);
  const std::size_t count = row * static_cast<std::size_t>(head.size[2]);
  float lowest = std::numeric_limits<float>::max();
  visit_voxel_type(head.type, [&]<class T>(std::type_identity<T>) {
    std::vector<T> slice(row);
    for (std::size_t first = 0; first < count; first += row) {
      receive_attachment(slice.data(), row * sizeof(T));
      for (std::size_t n = 0; n < row; ++n) {
        const auto value = static_cast<float>(slice[n]);
        voxels[first + n] = value;
        if (std::isfinite(value)) lowest = std::min(lowest, value);
      }
    }
  });
  for (std::size_t n = 0; n < count; ++n) {
    if (!std::isfinite(voxels[n])) voxels[n] = lowest;
  }
  return image;
}

void clip_extremes(FloatImage& image, const char* name) {
  constexpr double share = 0.001;
  float* const voxels = image.GetBufferPointer();
  const std::size_t count = image.GetLargestPossibleRegion().GetNumberOfPixels();
  std::vector<float> values(voxels, voxels + count);
  float low = quantile(values, share), high = quantile(values, 1 - share);
  if (!(low < high)) {
    low = *std::min_element(values.begin(), values.end());
    high = *std::max_element(values.begin(), values.end());
  }
  if (!(low < high))
    throw Error("cannot register the images", std::string("all voxels of the ") + name + " image are equal",
                "select another image");
  std::transform(voxels, voxels + count, voxels, [=](float value) { return std::clamp(value, low, high); });
}

FloatImage::Pointer coarsen(const FloatImage* image, double spacing_mm) {
  FloatImage::Pointer result = FloatImage::New();
  result->Graft(image);
  for (;;) {
    using Smoothing = itk::DiscreteGaussianImageFilter<FloatImage, FloatImage>;
    using Shrinking = itk::ShrinkImageFilter<FloatImage, FloatImage>;
    constexpr double variance = 0.8 * 0.8;
    Smoothing::ArrayType variances(0.0);
    Shrinking::ShrinkFactorsType factors(1u);
    bool halved = false;
    for (unsigned a = 0; a < kAxes; ++a) {
      if (1.5 * result->GetSpacing()[a] > spacing_mm || result->GetLargestPossibleRegion().GetSize()[a] < 4) continue;
      variances[a] = variance;
      factors[a] = 2;
      halved = true;
    }
    if (!halved) return result;
    const auto smoothing = Smoothing::New();
    smoothing->SetInput(result);
    smoothing->SetUseImageSpacing(false);
    smoothing->SetVariance(variances);
    const auto shrinking = Shrinking::New();
    shrinking->SetInput(smoothing->GetOutput());
    shrinking->SetShrinkFactors(factors);
    shrinking->Update();
    result = shrinking->GetOutput();
    result->DisconnectPipeline();
  }
}

FloatImage::Pointer normalise(const FloatImage* image, const Eigen::Vector3d& centre_mm, double scale_mm) {
  const auto result = FloatImage::New();
  result->Graft(image);
  FloatImage::PointType origin = image->GetOrigin();
  FloatImage::SpacingType spacing = image->GetSpacing();
  for (unsigned a = 0; a < kAxes; ++a) {
    origin[a] = (origin[a] - centre_mm[a]) / scale_mm;
    spacing[a] /= scale_mm;
  }
  result->SetOrigin(origin);
  result->SetSpacing(spacing);
  return result;
}

}  // namespace simplexseg::in_register
