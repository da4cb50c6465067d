// SPDX-License-Identifier: Apache-2.0
// Images of ITK in the worker process simplexseg-register.
#pragma once
#include <itkImage.h>

#include <Eigen/Geometry>

#include "io/registration/registration_requests.h"

namespace simplexseg::in_register {

using FloatImage = itk::Image<float, 3>;

/// Image with a grid and unspecified voxels.
FloatImage::Pointer make_image(const ImageHead& head);
/// Image whose voxels are the next attachment of the request, converted to float. Voxels that are not finite get the
/// smallest finite value.
FloatImage::Pointer receive_image(const ImageHead& head);
/// Grid of an image, with the type Float32.
ImageHead head_of(const FloatImage& image);

/// Limits the voxels to the quantiles 0.001 and 0.999, so that metal or hot voxels do not take all bins of a histogram.
/// Throws Error if all voxels are equal; `name`: name of the image in the message.
void clip_extremes(FloatImage& image, const char* name);

/// Image at a coarser resolution: axes are halved, after a Gaussian with a deviation of 0.8 voxels along them, as long
/// as their spacing stays below 4/3 `spacing_mm`. The result shares the voxels of `image` where nothing is to be
/// halved.
FloatImage::Pointer coarsen(const FloatImage* image, double spacing_mm);

/// Image with the same voxels in coordinates that are measured from `centre_mm` in units of `scale_mm`.
FloatImage::Pointer normalise(const FloatImage* image, const Eigen::Vector3d& centre_mm, double scale_mm);

}  // namespace simplexseg::in_register
