// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "image/volume.h"

namespace simplexseg {

/// A small synthetic volume with known truth.
struct Phantom {
  Volume image;
  Volume labels;  ///< uint8 on the same grid
};
struct PhantomSettings {
  int size = 64;  ///< voxels along each axis
  double spacing_mm = 1.0;
  double contrast = 100.0;  ///< object minus background
  double background = 50.0;
  double noise_sigma = 0.0;  ///< Gaussian, same unit as contrast
  std::uint64_t seed = 1;    ///< of the noise; the same seed gives the same voxels on every machine
  VoxelType type = VoxelType::Int16;
};
struct PhantomKind {
  const char* name;
  const char* doc;
};
/// sphere, ellipsoid, cube, torus, two-spheres, tube (a thin curved, bent tube), flat (constant image), ramp.
std::span<const PhantomKind> phantom_kinds();
/// Partial-volume (anti-aliased) edges; the volume's centre is the world's origin, its axes are the world's. Labels are
/// 1, for the second of two-spheres 2; flat and ramp have none. Throws Error for an unknown kind or
/// settings out of range.
Phantom make_phantom(const std::string& kind, const PhantomSettings& settings);
/// The label itself as the image: `background` outside, `background + contrast` inside, plus Gaussian noise, on the
/// label's own grid and in settings.type. Throws Error for settings out of range.
Volume image_of_label(const Volume& labels, std::optional<double> label, const PhantomSettings& settings);

}  // namespace simplexseg
