// SPDX-License-Identifier: Apache-2.0
// Features of the network of all marks.
#pragma once
#include <array>
#include <cmath>
#include <cstdint>

#include "core/vec3.h"
#include "field/box_grid.h"
#include "field/marked_voxels.h"

namespace simplexseg {

/// Ball of an inside or outside mark; a boundary mark has two.
struct MarkedBall {
  std::array<float, 3> index;  ///< of its centre, in the box
  float radius_mm;
  bool inside;  ///< else outside
};

/// mm^2 from a voxel to the centre of a ball.
SIMPLEXSEG_HD float square_to(const MarkedBall& ball, int i, int j, int k, const std::array<float, 3>& mm) {
  const float x = (static_cast<float>(i) - ball.index[0]) * mm[0], y = (static_cast<float>(j) - ball.index[1]) * mm[1],
              z = (static_cast<float>(k) - ball.index[2]) * mm[2];
  return x * x + y * y + z * z;
}

/// How far the image is from that in the inside marks, in deviations there.
struct Strangeness {
  static constexpr float kMost = 6;
  /// Within the inside marks, of the image and of it smoothed twice.
  std::array<float, 3> middle{}, per_deviation{1, 1, 1};

  SIMPLEXSEG_HD float operator()(int list, float value) const {
    return smaller(std::fabs(value - middle[list]) * per_deviation[list], kMost);
  }
};

/// Features of a cell that all marks together give: numbers without unit that mean the same in all images and for
/// objects of all sizes. How alike it looks, geodesic distances to the marks, distances in scales of the object, the
/// image on the straight line to the nearest inside mark. The network gives the probability of the object.
struct MarkView {
  static constexpr int kFeatures = 21;
  static constexpr int kMostSteps = 20;
  static constexpr float kStrange = 3;         // deviations
  static constexpr float kFarthestMark = 5;    // reaches
  static constexpr float kLeastWalk = 0.003f;  // and its rest: the most that the walk is believed
  // Reaches: where the wall is looked for.
  static constexpr float kShellFirst = 1.15f, kShellLast = 1.7f;

  BoxGrid grid;
  const Constraint* known;
  const float* image;                       ///< smoothed
  const float* smoothed[2];                 ///< by the second and the third feature of voxels
  const float *score, *walker;              ///< of the classifier; P(object) by the random walk of the marks alone
  const float *inside, *outside;            ///< geodesic distance to the marks
  const float *edges_in, *edges_out;        ///< edges passed on the way to them
  const float *from_inside, *from_outside;  ///< mm to the nearest centre of an inside, an outside mark, squared
  const std::uint16_t* nearest;             ///< of the balls of inside marks
  const MarkedBall* balls;                  ///< of all marks
  Strangeness strangeness;
  float noise;  ///< of neighbours in the marks
  float wall;   ///< how strange the shell about the marks is
  float reach_mm, radius_mm, least_mm;
  int marks;
  bool use_geodesic, use_random_walk;

  SIMPLEXSEG_HD float strange(int voxel) const { return strangeness(0, image[voxel]); }
  /// Whether a voxel lies where the wall is looked for.
  SIMPLEXSEG_HD bool is_in_shell(int voxel) const {
    const float low = kShellFirst * reach_mm, high = kShellLast * reach_mm, square = from_inside[voxel];
    return square > low * low && square < high * high && known[voxel] != Constraint::NotFinite;
  }

  /// What is strange between an inside mark's centre and a voxel.
  struct Line {
    float most = 0, mean = 0;
    float first = 1;  ///< share of the way on which nothing was
  };
  SIMPLEXSEG_HD Line line_to(int voxel) const {
    const std::array<float, 3>& from = balls[nearest[voxel]].index;
    const int at[3]{voxel % grid.size[0], voxel / grid.row() % grid.size[1], voxel / grid.plane()};
    float way[3], longest = 0;
    for (int a = 0; a < 3; ++a) {
      way[a] = static_cast<float>(at[a]) - from[a];
      longest = larger(std::fabs(way[a]), longest);
    }
    const int steps = smaller(larger(static_cast<int>(longest + 0.5f), 1), kMostSteps);
    const float step = 1 / static_cast<float>(steps);
    Line line;
    for (int s = 1; s <= steps; ++s) {
      const float t = static_cast<float>(s) * step;
      int v = 0;
      for (int a = 0; a < 3; ++a)
        v += grid.stride(a) * smaller(larger(static_cast<int>(from[a] + t * way[a] + 0.5f), 0), grid.size[a] - 1);
      const float here = strange(v);
      line.most = larger(here, line.most);
      line.mean += step * here;
      if (line.first == 1 && here > kStrange) line.first = t - step;
    }
    return line;
  }

  /// Calls set(f, value) for each feature f of a voxel.
  template <class Set>
  SIMPLEXSEG_HD void fill(int v, const Set& set) const {
    const float in = inside[v], out = outside[v], w = smaller(larger(walker[v], kLeastWalk), 1 - kLeastWalk);
    const float distance = std::sqrt(from_inside[v]), reaches = distance / reach_mm;
    const Line line = line_to(v);
    set(0, score[v]);
    set(1, use_geodesic ? (out - in) / (out + in + 1e-3f) : 0.0f);
    set(2, use_random_walk ? std::log(w / (1 - w)) : 0.0f);
    set(3, std::log(reaches + 0.1f));
    set(4, std::log(distance / balls[nearest[v]].radius_mm + 0.1f));
    set(5, std::log(smaller(std::sqrt(from_outside[v]) / reach_mm, kFarthestMark) + 0.1f));
    set(6, std::log(edges_in[v] + 0.05f));
    set(7, std::log(smaller(edges_out[v], 100.0f) + 0.05f));
    set(8, strange(v));
    for (int s = 1; s < 3; ++s) set(8 + s, strangeness(s, smoothed[s - 1][v]));
    set(11, line.most);
    set(12, line.mean);
    set(13, line.first);
    set(14, std::log(line.first * reaches + 0.1f));
    set(15, std::log(reach_mm / radius_mm));
    set(16, std::log(reach_mm / least_mm));
    set(17, std::log(noise));
    set(18, -std::log(strangeness.per_deviation[0]));
    set(19, wall);
    set(20, std::log(static_cast<float>(marks)));
  }
};

}  // namespace simplexseg
