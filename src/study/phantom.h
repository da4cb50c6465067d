// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "image/volume.h"

namespace simplexseg {

/// Synthetic image with its labels.
struct Phantom {
  Volume image;
  Volume labels;  ///< uint8 on the same grid
};
struct PhantomSettings {
  int size = 64;  ///< number of voxels along each axis
  double spacing_mm = 1.0;
  double contrast = 100.0;  ///< intensity of the object minus that of the background
  double background = 50.0;
  double noise_sigma = 0.0;  ///< standard deviation of the Gaussian noise, unit of the intensity
  std::uint64_t seed = 1;    ///< seed of the noise; the same seed gives the same voxels on every machine
  VoxelType type = VoxelType::Int16;
};
struct PhantomKind {
  const char* name;
  const char* doc;
};
/// Available phantoms: sphere, ellipsoid, cube, torus, two-spheres, tube (thin, curved), flat (constant image), ramp.
std::span<const PhantomKind> phantom_kinds();
/// Phantom with partial-volume (anti-aliased) edges, centred at the world origin and aligned with the world axes. The
/// label is 1, and 2 for the second sphere of two-spheres; flat and ramp have no label. Throws Error for an unknown
/// kind or settings out of range.
Phantom make_phantom(const std::string& kind, const PhantomSettings& settings);
/// Image of a label (none: of every voxel that is not 0): `background` outside, `background + contrast` inside, plus
/// Gaussian noise, on the grid of the labels and with the voxel type settings.type. Throws Error for settings out of
/// range.
Volume image_of_label(const Volume& labels, std::optional<double> label, const PhantomSettings& settings);

}  // namespace simplexseg
