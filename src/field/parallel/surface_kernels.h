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
#include "field/update_view.h"

namespace simplexseg::surface {

/// A part of a box.
struct PartOfBox {
  int first[3], size[3], outer[3];
  SIMPLEXSEG_HD int in_box(const CellAt& at) const {
    return ((at.k + first[2]) * outer[1] + at.j + first[1]) * outer[0] + at.i + first[0];
  }
};

struct CutPart {
  PartOfBox part;
  const std::uint8_t* object;
  const Constraint* known;
  const float *image, *probability;
  std::uint8_t *was, *is;
  Constraint* said;
  float *value, *field, *even;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    const int u = part.in_box(at), v = at.v;
    was[v] = is[v] = object[u], said[v] = known[u], value[v] = image[u], field[v] = even[v] = probability[u];
  }
};

/// The object of the field before.
struct CutBefore {
  PartOfBox part;
  const std::uint8_t* before;
  std::uint8_t* had;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    had[at.v] = before[part.in_box(at)] > kPreviousThreshold ? 1 : 0;
  }
};

/// Of every step-th voxel the difference to the next one along i, both in the object; else -1.
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

/// What sums around a voxel are made of: weight, value and square near the surface; `only`: of these voxels, null: all.
struct WeighedValues {
  const float *value, *distance;
  const std::uint8_t* only;
  float near_mm;
  float* to[3];
  SIMPLEXSEG_HD void operator()(int v) const {
    const float weight = distance[v] < near_mm && (only == nullptr || only[v]) ? 1.0f : 0.0f;
    to[0][v] = weight;
    to[1][v] = weight * value[v];
    to[2][v] = weight * value[v] * value[v];
  }
};

struct LooksOfVoxels {
  const float* value;
  const float *in[3], *all[3];
  const Selected* difference;  ///< the median one of NoiseSample
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const {
    const float noise = noise_of_median(difference->value_or(0));
    to[v] = look(value[v], in[0][v], in[1][v], in[2][v], all[0][v], all[1][v], all[2][v], noise * noise);
  }
};

/// The layer on either side of the surface, and what of it looks like its side.
struct PartsOfLayer {
  const float* look;
  const std::uint8_t* object;
  const float* distance;
  float layer_mm;
  float* to[4];
  SIMPLEXSEG_HD void operator()(int v) const {
    const bool layer = distance[v] < layer_mm, inner = object[v] != 0, agreed = (look[v] > 0) == inner;
    to[0][v] = layer && inner ? 1.0f : 0.0f;
    to[1][v] = layer && inner && agreed ? 1.0f : 0.0f;
    to[2][v] = layer && !inner ? 1.0f : 0.0f;
    to[3][v] = layer && !inner && agreed ? 1.0f : 0.0f;
  }
};

/// Inside marks in the layer, and of these that look like their side; then outside ones.
struct MarksInLayer {
  const float* look;
  const Constraint* said;
  const float* distance;
  float layer_mm;
  SIMPLEXSEG_HD Summands<4> operator()(int v) const {
    const bool layer = distance[v] < layer_mm, in = layer && said[v] == Constraint::Inside,
               out = layer && said[v] == Constraint::Outside, looks_in = look[v] > 0;
    return {{in ? 1.0f : 0.0f, in && looks_in ? 1.0f : 0.0f, out ? 1.0f : 0.0f, out && !looks_in ? 1.0f : 0.0f}};
  }
};

/// What is believed of looks: around a voxel, and by the marks of the kind that they agree with less.
struct TrustOfVoxels {
  const float* parts[4];
  const double* marks;  ///< inside: in the layer, agreed; outside: the same
  float* to;
  SIMPLEXSEG_HD void operator()(int v) const {
    float least = 1;
    for (int kind = 0; kind < 2; ++kind) {
      const float count = kUnmarkedVoxels + static_cast<float>(marks[2 * kind]),
                  agreed = kUnmarkedVoxels + static_cast<float>(marks[2 * kind + 1]);
      least = smaller(agreed / count, least);
    }
    to[v] = trust(parts[0][v], parts[1][v], parts[2][v], parts[3][v]) *
            weight_of(least, kLeastMarkAgreement, kFullMarkAgreement);
  }
};

/// Which voxels of the layer may change.
struct CanChange {
  const Constraint* said;
  const float* distance;
  float layer_mm;
  SIMPLEXSEG_HD bool operator()(int v) const { return said[v] == Constraint::None && distance[v] < layer_mm; }
};

/// `once`, `twice`: the field after one Gaussian and after two. A second one gives back what the first takes from a
/// surface that bends (Taubin 1995).
struct OddsOfVoxels {
  CanChange can_change;
  const float *field, *once, *twice, *look, *trust;
  float lean;
  HeldSurface held;
  float* to;
  std::uint8_t* is;
  SIMPLEXSEG_HD void operator()(int v) const {
    if (!can_change(v)) return;
    to[v] = odds(field[v], 2 * once[v] - twice[v], look[v], trust[v], lean + held(v, trust[v]));
    is[v] = to[v] > 0 ? 1 : 0;
  }
};

struct WriteSettled {
  CanChange can_change;
  PartOfBox part;
  const float* odds;
  float* probability;
  SIMPLEXSEG_HD void operator()(const CellAt& at) const {
    if (can_change(at.v)) probability[part.in_box(at)] = probability_of(odds[at.v]);
  }
};

/// The field, the field in the object, and the object.
struct FieldAndObject {
  const float* probability;
  const std::uint8_t* object;
  SIMPLEXSEG_HD Summands<3> operator()(int v) const {
    const float p = probability[v];
    return {{p, object[v] ? p : 0.0f, object[v] ? 1.0f : 0.0f}};
  }
};

}  // namespace simplexseg::surface
