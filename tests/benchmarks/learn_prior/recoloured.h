// SPDX-License-Identifier: Apache-2.0
// Synthetic grey values on real anatomy.
#pragma once
#include <utility>

#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// The object and its surroundings in random grey values: one or two for each label, five for unlabelled voxels by
/// their intensity, some equal to those of the object. A random share of the image's texture, a gradual change, blur
/// and noise are added. After Billot et al. 2023 (SynthSeg), who draw grey values for label maps only. `labels` and
/// `truth`, the object, are on the grid of `image`; the result is a function of `seed`.
std::pair<Volume, Mask> recoloured(const Volume& image, const Volume& labels, const Mask& truth, unsigned seed);

}  // namespace simplexseg
