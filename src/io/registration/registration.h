// SPDX-License-Identifier: Apache-2.0
// Registration of two images by ITK, in the worker process simplexseg-register (docs/adr/0058-registration.md).
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "image/transform.h"
#include "image/volume.h"

namespace simplexseg {

/// Transforms that a registration finds, each from the result of those before.
enum class RegistrationKind : std::uint8_t { Rigid, Affine, Displacement };

/// Measure of the agreement that a displacement field improves. Rigid and affine transforms are always found by mutual
/// information.
enum class FieldMetric : std::uint8_t {
  MutualInformation,  ///< images of any modality
  SquaredDifferences  ///< images of one scanner and sequence, with equal values for equal tissue, such as time points
};

/// Start of a registration without a given transform.
enum class RegistrationStart : std::uint8_t {
  Centres,  ///< centres and identity, with rotations up to 20 degrees about each axis, compared at a low resolution
  None      ///< identity
};

/// Parameters of a registration. The result depends on them alone, not on the number of threads.
struct RegistrationSettings {
  RegistrationKind kind = RegistrationKind::Rigid;
  RegistrationStart start = RegistrationStart::Centres;
  std::optional<Eigen::Affine3d> initial{};  ///< start from this transform instead
  int threads = 0;                           ///< number of threads, 0 for all cores
  /// Whether the histograms of both images are equalised before (equalised()): mutual information then distinguishes
  /// soft tissues in images with a large range of values, such as CT.
  bool equalise = false;
  FieldMetric field_metric = FieldMetric::MutualInformation;
};

/// State of a registration, for a progress display.
struct RegistrationProgress {
  std::string stage;      ///< "search", "rigid", "affine", "displacement"
  double spacing_mm = 0;  ///< voxel spacing of the current resolution level
  int iteration = 0;
  double metric = 0;  ///< value of the metric, lower is better
  double done = 0;    ///< estimated share of the work, 0 to 1
};

/// Iterations of one stage at one resolution level.
struct RegistrationLevel {
  std::string stage;
  double spacing_mm = 0;
  int iterations = 0;
  double metric = 0;  ///< value of the metric at the end, lower is better
};

struct RegistrationResult {
  Transform transform;       ///< maps points of the fixed image to the moving image
  double metric_before = 0;  ///< negative mutual information, nats, of the images as they are: lower is better
  double metric_after = 0;   ///< and through the transform, at the same samples
  std::vector<RegistrationLevel> levels;
};

/// Registers `moving` to `fixed` by mutual information. Voxels that are not finite count as the smallest finite value.
/// `on_progress` is called in this thread. Throws Error for images that do not overlap or are constant, a missing
/// worker program, or one that was killed; throws Cancelled after a cancellation of the bound LoadProgress.
RegistrationResult register_images(const Volume& fixed, const Volume& moving, const RegistrationSettings& settings,
                                   const std::function<void(const RegistrationProgress&)>& on_progress = {});

}  // namespace simplexseg
