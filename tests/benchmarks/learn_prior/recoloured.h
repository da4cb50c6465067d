// SPDX-License-Identifier: Apache-2.0
// Real anatomy in the grey values of images that nobody has taken.
#pragma once
#include <utility>

#include "image/mask.h"
#include "image/volume.h"

namespace simplexseg {

/// The object and what lies around it, in other grey values, drawn at random: every label has one or two of its own,
/// what has no label one for each of five kinds of voxels by their intensity, some the same as the object's; on them
/// the image's own texture, more or less of it, a slow change, blur and noise. After Billot et al. 2023 (SynthSeg), who
/// draw the grey values of label maps alone. `labels` and `truth`, the object, are on the grid of `image`; the same
/// `seed`, the same image.
std::pair<Volume, Mask> recoloured(const Volume& image, const Volume& labels, const Mask& truth, unsigned seed);

}  // namespace simplexseg
