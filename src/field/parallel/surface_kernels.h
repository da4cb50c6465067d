// SPDX-License-Identifier: Apache-2.0
// Kernels of refine_in_narrow_band() on an executor (parallel/surface.h).
#pragma once
#include <cmath>
#include <cstdint>

#include "core/vec3.h"
#include "field/marked_voxels.h"
#include "field/parallel/executor.h"
#include "field/parallel/select.h"
#include "field/surface_voxel.h"

namespace simplexseg::surface {

/// Part of a box that contains the band.
struct PartOfBox {
  int first[3], size[3], outer[3];  ///< `outer`: size of the box
  SIMPLEXSEG_HD int in_box(const CellAt& at) const {
    return ((at.k + first[2]) * outer[1] + at.j + first[1]) * outer[0] + at.i + first[0];
  }
};

/// Copies the part from the arrays of the box.
struct CopyPart {
  PartOfBox part;
  const std::uint8_t* object;
  const Constraint* constraints;
  const float *image, *probability;
  std::uint8_t *initial, *present;
  Constraint* marked;
  float *intensity, *field, *faired;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const int u = part.in_box(at), v = at.v;
    initial[v] = present[v] = object[u], marked[v] = constraints[u];
    intensity[v] = image[u], field[v] = faired[v] = probability[u];
  }
};

/// Intensity difference of every step-th voxel and the next one along i, if both are in the object; else -1.
struct NoiseSample {
  const std::uint8_t* object;
  const float* image;
  int count, step, row;
  SIMPLEXSEG_HD float operator()(int sample) const {
    const int v = sample * step;
    if (v + 1 >= count || !object[v] || !object[v + 1] || (v + 1) % row == 0) return -1;
    return std::fabs(image[v + 1] - image[v]);
  }
};

/// Weight, intensity and squared intensity of cells near the surface, for sums in Gaussian windows.
struct WindowMoments {
  const float *intensity, *distance;
  const std::uint8_t* set;  ///< cells with a weight; null: all
  float near_mm;
  float* to[3];
  SIMPLEXSEG_HD void operator()(int v) const {
    const float weight = distance[v] < near_mm && (set == nullptr || set[v]) ? 1.0f : 0.0f;
    to[0][v] = weight;
    to[1][v] = weight * intensity[v];
    to[2][v] = weight * intensity[v] * intensity[v];
  }
};

struct AppearanceOfCells {
  const float* intensity;
  const float *in[3], *all[3];  ///< smoothed WindowMoments, of the object and of both sides
  const Selected* difference;   ///< median of NoiseSample
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const {
    const float noise = noise_of_median(difference->value_or(0));
    to[v] =
        appearance_log_odds(intensity[v], in[0][v], in[1][v], in[2][v], all[0][v], all[1][v], all[2][v], noise * noise);
  }
};

/// Indicators of the band in the object and of its cells where appearance agrees; then of both outside the object.
struct BandAgreement {
  const float* appearance;
  const std::uint8_t* object;
  const float* distance;
  float band_mm;
  float* to[4];
  SIMPLEXSEG_HD void operator()(int v) const {
    const bool band = distance[v] < band_mm, inner = object[v] != 0, agreed = (appearance[v] > 0) == inner;
    to[0][v] = band && inner ? 1.0f : 0.0f;
    to[1][v] = band && inner && agreed ? 1.0f : 0.0f;
    to[2][v] = band && !inner ? 1.0f : 0.0f;
    to[3][v] = band && !inner && agreed ? 1.0f : 0.0f;
  }
};

/// Indicators of inside marks in the band and of those where appearance agrees; then of outside marks.
struct MarksInBand {
  const float* appearance;
  const Constraint* constraints;
  const float* distance;
  float band_mm;
  SIMPLEXSEG_HD Summands<4> operator()(int v) const {
    const bool band = distance[v] < band_mm, in = band && constraints[v] == Constraint::Inside,
               out = band && constraints[v] == Constraint::Outside, is_inside = appearance[v] > 0;
    return {{in ? 1.0f : 0.0f, in && is_inside ? 1.0f : 0.0f, out ? 1.0f : 0.0f, out && !is_inside ? 1.0f : 0.0f}};
  }
};

/// Weights of appearance: agreement in the band around a voxel, times that of the kind of marks with the lower
/// agreement.
struct AppearanceWeights {
  const float* sides[4];  ///< smoothed BandAgreement
  const double* marks;    ///< sums of MarksInBand
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const {
    float least = 1;
    for (int kind = 0; kind < 2; ++kind) {
      const float count = kUnmarkedVoxels + static_cast<float>(marks[2 * kind]),
                  agreed = kUnmarkedVoxels + static_cast<float>(marks[2 * kind + 1]);
      least = smaller(agreed / count, least);
    }
    to[v] = local_weight(sides[0][v], sides[1][v], sides[2][v], sides[3][v]) *
            agreement_weight(least, kLeastMarkAgreement, kFullMarkAgreement);
  }
};

/// Whether a voxel is in the band without a constraint.
struct CanChange {
  const Constraint* constraints;
  const float* distance;
  float band_mm;
  SIMPLEXSEG_HD bool operator()(int v) const { return constraints[v] == Constraint::None && distance[v] < band_mm; }
};

/// Log odds of the band, and its object. Fairing by one and two Gaussians with the weights 2 and -1 shrinks a curved
/// surface less than one Gaussian. Source: Taubin 1995, A Signal Processing Approach to Fair Surface Design.
struct LogOddsOfBand {
  CanChange can_change;
  const float *field, *smoothed_once, *smoothed_twice, *appearance, *weight;
  float offset;
  TemporalTerm temporal;
  float* to;
  std::uint8_t* object;
  SIMPLEXSEG_HD void operator()(int v) const {
    if (!can_change(v)) return;
    to[v] = band_log_odds(field[v], 2 * smoothed_once[v] - smoothed_twice[v], appearance[v], weight[v],
                          offset + temporal(v, weight[v]));
    object[v] = to[v] > 0 ? 1 : 0;
  }
};

/// Summands of the expected Dice: probability, probability in the object, and the object.
struct FieldAndObject {
  const float* probability;
  const std::uint8_t* object;
  SIMPLEXSEG_HD Summands<3> operator()(int v) const {
    const float p = probability[v];
    return {{p, object[v] ? p : 0.0f, object[v] ? 1.0f : 0.0f}};
  }
};

}  // namespace simplexseg::surface
