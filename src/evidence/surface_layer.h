// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "evidence/evidence_settings.h"
#include "evidence/field_object.h"
#include "evidence/marked_voxels.h"
#include "evidence/run_jobs.h"
#include "evidence/surface_voxel.h"
#include "image/distance_map.h"

namespace simplexseg {

/// Lets the image say where in a thin layer about the object's surface the surface is: what a voxel looks like beside
/// what the object and what is not the object look like around it, Gaussians of a local mean and variance on either
/// side (Li, Kao, Gore and Ding 2008, Minimization of Region-Scalable Fitting Energy; Lankton and Tannenbaum 2008,
/// Localizing Region-Based Active Contours), is added to the field's log odds. How far it is believed: by how much of
/// the layer around the voxel it and the field say the same of, and by how many of the object's marks in the layer it
/// agrees with. Where they are not believed the surface is smooth. docs/adr/0024-narrow-band.md.
///
/// `said`: what marks say of the surface (docs/adr/0026-band-offset-from-marks.md,
/// docs/adr/0033-temporal-term.md). `before`: the field before the new ones, 1..255 for 0..1, 0: not known; or
/// empty, and only the lean of `said` is heard. `probability`: the field of the box, changed where nothing is known and
/// within `surface_layer` of the surface; `image`: BoxImage::value, not smoothed; `object`: object_of_field() of this
/// field.
void refine_in_narrow_band(std::span<float> probability, const FieldObject& object, std::span<const Constraint> known,
                           std::span<const float> image, std::span<const std::uint8_t> before, const VoxelBox& box,
                           const std::array<double, 3>& spacing_mm, const BandTerms& said,
                           const EvidenceSettings& settings, const RunJobs& run);

}  // namespace simplexseg
