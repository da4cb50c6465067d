// SPDX-License-Identifier: Apache-2.0
#include "register/bias_field.h"

#include <itkBSplineControlPointImageFilter.h>
#include <itkN4BiasFieldCorrectionImageFilter.h>
#include <itkOtsuThresholdImageFilter.h>
#include <itkShrinkImageFilter.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace simplexseg::in_register {

FloatImage::Pointer without_bias_field(const FloatImage* image, int shrink, int levels, int iterations,
                                       ProgressSender& progress) {
  using Mask = itk::Image<unsigned char, 3>;
  using Correction = itk::N4BiasFieldCorrectionImageFilter<FloatImage, Mask, FloatImage>;
  const auto size = image->GetLargestPossibleRegion().GetSize();
  const auto reduced = itk::ShrinkImageFilter<FloatImage, FloatImage>::New();
  reduced->SetInput(image);
  for (unsigned a = 0; a < 3; ++a)  // at least 8 voxels remain along an axis that has them
    reduced->SetShrinkFactor(a, static_cast<unsigned>(std::clamp<itk::SizeValueType>(
                                    size[a] / 8, 1, static_cast<itk::SizeValueType>(shrink))));
  reduced->Update();
  const auto otsu = itk::OtsuThresholdImageFilter<FloatImage, Mask>::New();
  otsu->SetInput(reduced->GetOutput());
  otsu->SetInsideValue(0);  // up to the threshold
  otsu->SetOutsideValue(1);
  otsu->SetNumberOfHistogramBins(200);
  otsu->Update();
  const Mask* const mask = otsu->GetOutput();
  const unsigned char* const voxels = mask->GetBufferPointer();
  const std::size_t count = mask->GetLargestPossibleRegion().GetNumberOfPixels();
  if (std::find(voxels, voxels + count, 1) == voxels + count)
    throw Error("cannot estimate the bias field", "the image has no foreground", "select another image");
  const auto correction = Correction::New();
  correction->SetInput(reduced->GetOutput());
  correction->SetMaskImage(mask);
  correction->SetMaskLabel(1);
  Correction::VariableSizeArrayType most(static_cast<unsigned>(levels));
  most.Fill(static_cast<unsigned>(iterations));
  correction->SetMaximumNumberOfIterations(most);
  Correction::ArrayType fitting;
  fitting.Fill(static_cast<unsigned>(levels));
  correction->SetNumberOfFittingLevels(fitting);
  correction->SetConvergenceThreshold(0.001);
  int iteration = 0;
  correction->AddObserver(itk::IterationEvent(), [&](const itk::EventObject&) {
    ++iteration;
    progress.send({"filter", 0, iteration, 0, std::min(1.0, iteration / (1.0 * levels * iterations))});
  });
  correction->Update();
  // The lattice spans the reduced image; its field is evaluated at the voxels of the whole one.
  using Lattice = Correction::BiasFieldControlPointLatticeType;
  using Evaluation = itk::BSplineControlPointImageFilter<Lattice, Correction::ScalarImageType>;
  const auto evaluation = Evaluation::New();
  evaluation->SetInput(correction->GetLogBiasFieldControlPointLattice());
  evaluation->SetSplineOrder(correction->GetSplineOrder());
  evaluation->SetOrigin(image->GetOrigin());
  evaluation->SetSpacing(image->GetSpacing());
  evaluation->SetDirection(image->GetDirection());
  evaluation->SetSize(size);
  evaluation->Update();
  const auto* const logarithm = evaluation->GetOutput()->GetBufferPointer();
  const auto result = FloatImage::New();
  result->CopyInformation(image);
  result->SetRegions(size);
  result->Allocate();
  const float* const from = image->GetBufferPointer();
  float* const to = result->GetBufferPointer();
  for (std::size_t n = 0; n < image->GetLargestPossibleRegion().GetNumberOfPixels(); ++n)
    to[n] = from[n] / std::exp(static_cast<float>(logarithm[n][0]));
  return result;
}

}  // namespace simplexseg::in_register
