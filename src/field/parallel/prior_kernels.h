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

namespace simplexseg {

inline constexpr float kFarSquare = 1e12f;  ///< mm^2, where there is no mark

/// A place in the indices of a grid.
struct IndexPlace {
  float index[3];
};
/// mm^2 between places of a grid whatever the directions of its axes are.
struct SquareInMm {
  float mm[3][3];  ///< of a difference of indices
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

/// What lies near a block: the nearest mark of each kind and the nearest new mark, and where ways to them start.
struct NearestMarks {
  BoxGrid grid;
  SquareInMm square_mm;
  std::array<float, 3> spacing_mm;
  const MarkedBall* balls;
  const IndexPlace *inside, *fresh;  ///< places of inside and boundary marks; centres of the new balls
  const NewMarkVoxel* fresh_balls;
  int ball_count, inside_count, fresh_count;
  const Constraint* known;
  float *from_inside, *from_outside, *fresh_square;
  std::uint16_t *nearest, *nearest_fresh;
  float *to_inside, *edges_in, *edges_to_fresh;

  SIMPLEXSEG_HD void operator()(const CellAt& p) const {
    const int v = p.v;
    float in = kFarSquare, out = kFarSquare, least = kFarSquare;
    int of_ball = 0, of_fresh = 0;
    for (int m = 0; m < inside_count; ++m) in = smaller(square_mm(p, inside[m]), in);
    from_inside[v] = in;
    for (int b = 0; b < ball_count; ++b) {
      const float square = square_to(balls[b], p.i, p.j, p.k, spacing_mm);
      if (!balls[b].inside)
        out = smaller(square, out);
      else if (square < least)
        least = square, of_ball = b;
    }
    from_outside[v] = out;
    nearest[v] = static_cast<std::uint16_t>(of_ball);
    to_inside[v] = edges_in[v] = start_of_way(is_inside_start(known[v]));
    float to_fresh = kFarSquare;
    bool start = false;
    for (int m = 0; m < fresh_count; ++m) {
      const float square = square_mm(p, fresh[m]), radius = fresh_balls[m].radius_mm;
      if (square < to_fresh) to_fresh = square, of_fresh = m;
      start |= square <= radius * radius || fresh_balls[m].voxel == v;
    }
    fresh_square[v] = to_fresh;
    nearest_fresh[v] = static_cast<std::uint16_t>(of_fresh);
    edges_to_fresh[v] = start_of_way(start);
  }
};

struct StartOutside {
  const Constraint* known;
  const std::uint8_t* open;
  float *outside, *edges_out;
  SIMPLEXSEG_HD void operator()(int v) const {
    outside[v] = edges_out[v] = start_of_way(is_outside_start(known[v], open[v] != 0));
  }
};

/// What the walk of the marks alone is given.
struct StartWalk {
  const Constraint* known;
  const std::uint8_t* open;
  std::uint8_t *held, *finite;
  float* field;
  SIMPLEXSEG_HD void operator()(int v) const {
    finite[v] = known[v] != Constraint::NotFinite;
    held[v] = is_dirichlet(known[v]) && !open[v];
    if (held[v]) field[v] = known[v] == Constraint::Inside ? 1.0f : 0.0f;
  }
};

/// Bin of a block of the shell about the marks by how strange it is: for the median, to a thousandth of the largest.
struct BinOfShell {
  MarkView view;
  SIMPLEXSEG_HD int operator()(int v) const {
    if (!view.is_in_shell(v)) return -1;
    return static_cast<int>(view.strange(v) * ((kBins - 1) / Strangeness::kMost));
  }
};

struct WasObject {
  const std::uint8_t* before;
  std::uint8_t* to;
  SIMPLEXSEG_HD void operator()(int v) const { to[v] = before[v] > kPreviousThreshold ? 1 : 0; }
};
struct Inward {
  const std::uint8_t* was_object;
  const float* squares;  ///< of the distance to the other side, mm^2
  float least_mm;
  float* inward;
  SIMPLEXSEG_HD void operator()(int v) const {
    inward[v] = inward_mm(std::sqrt(squares[v]), was_object[v] != 0, least_mm);
  }
};

/// view.prior_of_marks may be `prior`.
struct PriorAfterUpdate {
  UpdateView view;
  NetworkView network;
  std::uint8_t* prior;
  template <int kLanes>
  SIMPLEXSEG_HD void run(int v) const {
    std::uint8_t probability[kLanes];
    network.evaluate<kLanes>(view, v, probability);
    for (int l = 0; l < kLanes; ++l) prior[v + l] = view.with_memory(v + l, probability[l]);
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

struct BinOfCut {
  const Constraint* known;
  const std::uint8_t* prior;
  SIMPLEXSEG_HD int operator()(int v) const { return counted_for_cut(known[v], prior[v]); }
};
struct MoveToCut {
  double raise;
  std::uint8_t* prior;
  SIMPLEXSEG_HD void operator()(int v) const { prior[v] = moved_by(prior[v], raise); }
};

}  // namespace simplexseg
