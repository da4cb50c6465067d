// SPDX-License-Identifier: Apache-2.0
// Kernels of the prior over its blocks.
#pragma once
#include <cmath>
#include <cstdint>

#include "field/field_prior.h"
#include "field/mark_measures.h"
#include "field/mark_view.h"
#include "field/parallel/constraints.h"
#include "field/parallel/network.h"
#include "field/update_view.h"
#include "field/voxel_features.h"

namespace simplexseg {

inline constexpr float kFarSquare = 1e12f;  ///< squared distance without a mark, mm^2

/// Place in the indices of a grid.
struct IndexPlace {
  float index[3];
};
/// Squared distance between places of a grid, whose axes may be oblique, mm^2.
struct SquareInMm {
  float mm[3][3];  ///< from a difference of indices to mm
  SIMPLEXSEG_HD float operator()(const CellAt& p, const IndexPlace& q) const {
    const float x = static_cast<float>(p.i) - q.index[0], y = static_cast<float>(p.j) - q.index[1],
                z = static_cast<float>(p.k) - q.index[2];
    float sum = 0;
    for (int a = 0; a < 3; ++a) {
      const float d = mm[a][0] * x + mm[a][1] * y + mm[a][2] * z;
      sum += d * d;
    }
    return sum;
  }
};

/// Nearest mark of each kind and nearest new mark of a block, and the sources of geodesic distances to them.
struct NearestMarks {
  BoxGrid grid;
  SquareInMm square_mm;
  std::array<float, 3> spacing_mm;
  const MarkedBall* balls;
  const IndexPlace *inside, *new_centres;  ///< inside and boundary marks; centres of the new balls
  const NewMarkVoxel* new_balls;
  int ball_count, inside_count, new_count;
  const Constraint* constraints;
  float *from_inside, *from_outside, *new_square;
  std::uint16_t *nearest, *nearest_new;
  float *to_inside, *edges_in, *edges_to_new;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const int v = p.v;
    float in = kFarSquare, out = kFarSquare, least = kFarSquare;
    int inside_ball = 0, new_ball = 0;
    for (int m = 0; m < inside_count; ++m) in = smaller(square_mm(p, inside[m]), in);
    from_inside[v] = in;
    for (int b = 0; b < ball_count; ++b) {
      const float square = square_to(balls[b], p.i, p.j, p.k, spacing_mm);
      if (!balls[b].inside)
        out = smaller(square, out);
      else if (square < least)
        least = square, inside_ball = b;
    }
    from_outside[v] = out;
    nearest[v] = static_cast<std::uint16_t>(inside_ball);
    to_inside[v] = edges_in[v] = initial_distance(is_inside_source(constraints[v]));
    float to_new = kFarSquare;
    bool is_source = false;
    for (int m = 0; m < new_count; ++m) {
      const float square = square_mm(p, new_centres[m]), radius = new_balls[m].radius_mm;
      if (square < to_new) to_new = square, new_ball = m;
      is_source |= square <= radius * radius || new_balls[m].voxel == v;
    }
    new_square[v] = to_new;
    nearest_new[v] = static_cast<std::uint16_t>(new_ball);
    edges_to_new[v] = initial_distance(is_source);
  }
};

struct OutsideSources {
  const Constraint* constraints;
  const std::uint8_t* open;
  float *outside, *edges_out;
  SIMPLEXSEG_HD void operator()(int v) const {
    outside[v] = edges_out[v] = initial_distance(is_outside_source(constraints[v], open[v] != 0));
  }
};

/// Fixed blocks of the random walker of the marks alone, and their values.
struct RandomWalkConstraints {
  const Constraint* constraints;
  const std::uint8_t* open;
  std::uint8_t *fixed, *finite;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    finite[v] = constraints[v] != Constraint::NotFinite;
    fixed[v] = is_dirichlet(constraints[v]) && !open[v];
    if (fixed[v]) field[v] = constraints[v] == Constraint::Inside ? 1.0f : 0.0f;
  }
};

/// z-score of several images: root mean square of those of each image, for the smoothed image and the two smoothed
/// features.
struct CombineZScores {
  const float* image;               ///< smoothed main image
  const float* features;            ///< voxel_features() of all images, one list after another
  const IntensityZScore* z_scores;  ///< of each image
  int images, blocks;
  float* to;  ///< three lists

  SIMPLEXSEG_HD void operator()(int v) const {
    for (int l = 0; l < 3; ++l) {
      float sum = 0;
      for (int n = 0; n < images; ++n) {
        const float* const list = n == 0 && l == 0 ? image : features + (kVoxelFeatures * n + l) * blocks;
        const float z = z_scores[n](l, list[v]);
        sum += z * z;
      }
      to[l * blocks + v] = std::sqrt(sum / static_cast<float>(images));
    }
  }
};

/// Bin of the z-score of a block in the shell around the marks, for the median; -1 elsewhere.
struct BinOfShell {
  MarkView view;
  SIMPLEXSEG_HD int operator()(int v) const {
    if (!view.is_in_shell(v)) return -1;
    return static_cast<int>(view.image_z_score(v) * ((kBins - 1) / IntensityZScore::kMost));
  }
};

struct PreviousObject {
  const std::uint8_t* previous;
  std::uint8_t* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = previous[v] > kPreviousThreshold ? 1 : 0; }
};
struct Inward {
  const std::uint8_t* previous_object;
  const float* squares;  ///< squared distance to the other side, mm^2
  float least_spacing_mm;
  float* inward;
  SIMPLEXSEG_HD void operator()(int v) const {
    inward[v] = inward_mm(std::sqrt(squares[v]), previous_object[v] != 0, least_spacing_mm);
  }
};

/// Prior of blocks with new marks, from the network of new marks and the previous field. view.prior_of_marks may be
/// `prior`.
struct PriorAfterUpdate {
  UpdateView view;
  NetworkView network;
  std::uint8_t* prior;
  template <int kLanes>
  SIMPLEXSEG_HD void run(int v) const {
    std::uint8_t probability[kLanes];
    network.evaluate<kLanes>(view, v, probability);
    for (int l = 0; l < kLanes; ++l) prior[v + l] = view.blend_previous(v + l, probability[l]);
  }
};

/// Writes the features of a view, one list per feature.
template <class View>
struct RecordedFeatures {
  View view;
  float* to;
  int blocks;
  SIMPLEXSEG_HD void operator()(int v) const {
    view.fill(v, [&](int f, float value) { to[f * blocks + v] = value; });
  }
};
struct NearestIsInside {
  UpdateView view;
  std::uint8_t* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = view.nearest_is_inside(v) ? 1 : 0; }
};

struct BinOfThreshold {
  const Constraint* constraints;
  const std::uint8_t* prior;
  SIMPLEXSEG_HD int operator()(int v) const { return threshold_bin(constraints[v], prior[v]); }
};
struct ScaleOdds {
  double factor;
  std::uint8_t* prior;
  SIMPLEXSEG_HD void operator()(int v) const { prior[v] = scaled_odds(prior[v], factor); }
};

/// Adds log odds to those of a prior.
struct AddLogOdds {
  const float* log_odds;
  std::uint8_t* prior;
  SIMPLEXSEG_HD void operator()(int v) const {
    const float least = 0.5f / 255, p = smaller(larger(prior[v] / 255.0f, least), 1 - least);
    prior[v] = network_output(std::log(p / (1 - p)) + log_odds[v]);
  }
};

}  // namespace simplexseg
