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
  std::array<float, 3> index;  ///< of its centre, index in the box
  float radius_mm;
  bool inside;  ///< else outside
};

/// Squared distance from a voxel to the centre of a ball, mm^2. `mm`: spacing.
SIMPLEXSEG_HD float square_to(const MarkedBall& ball, int i, int j, int k, const std::array<float, 3>& mm) {
  const float x = (static_cast<float>(i) - ball.index[0]) * mm[0], y = (static_cast<float>(j) - ball.index[1]) * mm[1],
              z = (static_cast<float>(k) - ball.index[2]) * mm[2];
  return x * x + y * y + z * z;
}

/// Robust z-score of an intensity relative to the inside marks, absolute and at most kMost.
struct IntensityZScore {
  static constexpr float kMost = 6;
  /// Median and inverse standard deviation within the inside marks, of the image and of two smoothed ones.
  std::array<float, 3> median{}, inverse_deviation{1, 1, 1};

  SIMPLEXSEG_HD float operator()(int list, float value) const {
    return smaller(std::fabs(value - median[list]) * inverse_deviation[list], kMost);
  }
};

/// Features of a cell from all marks, without unit and comparable between images and sizes of objects: appearance,
/// geodesic distances to the marks, distances in object scales, intensities on the straight line to the nearest inside
/// mark. The output of their network is the foreground probability. Source: docs/mathematics.md 8.4.
struct MarkView {
  /// Features, in the order of the inputs of the network; formulas: docs/mathematics.md 8.4.
  enum Feature {
    kAppearance,
    kGeodesicRatio,
    kRandomWalk,
    kDistanceInScales,
    kDistanceInRadii,
    kOutsideDistance,
    kEdgesInside,
    kEdgesOutside,
    kZScore,
    kZScoreSecond,
    kZScoreThird,
    kLineLargest,
    kLineMean,
    kLineClear,
    kLineClearLength,
    kScaleInRadii,
    kBlocksPerScale,
    kNoise,
    kSpread,
    kShellContrast,
    kMarkCount,
    kFeatures
  };
  /// Names of the features, stored with the weights of the network.
  static constexpr std::array<const char*, kFeatures> kFeatureNames = {"appearance",
                                                                       "geodesic_ratio",
                                                                       "random_walk",
                                                                       "distance_in_scales",
                                                                       "distance_in_radii",
                                                                       "outside_distance",
                                                                       "edges_inside",
                                                                       "edges_outside",
                                                                       "z_score",
                                                                       "z_score_second",
                                                                       "z_score_third",
                                                                       "line_largest",
                                                                       "line_mean",
                                                                       "line_clear",
                                                                       "line_clear_length",
                                                                       "scale_in_radii",
                                                                       "blocks_per_scale",
                                                                       "noise",
                                                                       "spread",
                                                                       "shell_contrast",
                                                                       "mark_count"};
  static constexpr int kMostSteps = 20;
  static constexpr float kEdgeZScore = 3;                         // z-score of other tissue on the line
  static constexpr float kFarthestMark = 5;                       // object scales
  static constexpr float kLeastWalkerProbability = 0.003f;        // bound of the random walker in its logit
  static constexpr float kShellFirst = 1.15f, kShellLast = 1.7f;  // radii of the shell around the marks, object scales

  BoxGrid grid;
  const Constraint* constraints;
  const float* image;                       ///< smoothed; with several images combined z-scores (CombineZScores)
  const float* smoothed[2];                 ///< second and third of voxel_features(), or combined z-scores
  const float *score, *walker;              ///< appearance score; foreground probability by the random walker
  const float *inside, *outside;            ///< geodesic distances to the marks by cost_of_changes()
  const float *edges_in, *edges_out;        ///< geodesic distances to the marks by cost_of_edges()
  const float *from_inside, *from_outside;  ///< squared distance to the nearest inside mark, outside ball, mm^2
  const std::uint16_t* nearest;             ///< inside ball with the nearest centre
  const MarkedBall* balls;                  ///< of all marks
  IntensityZScore z_score;
  float inverse_deviation;  ///< IntensityZScore::inverse_deviation of the smoothed image
  float noise;              ///< noise_of()
  float shell_contrast;     ///< median z-score in the shell around the marks
  float scale_mm, radius_mm, least_spacing_mm;
  int ball_count;
  int marks;  ///< prompt_ball_count()
  bool use_geodesic, use_random_walk;

  SIMPLEXSEG_HD float image_z_score(int voxel) const { return z_score(0, image[voxel]); }
  /// Whether a voxel is in the shell around the marks.
  SIMPLEXSEG_HD bool is_in_shell(int voxel) const {
    const float low = kShellFirst * scale_mm, high = kShellLast * scale_mm, square = from_inside[voxel];
    return square > low * low && square < high * high && constraints[voxel] != Constraint::NotFinite;
  }

  /// z-scores on the line from the centre of the nearest inside ball to a voxel.
  struct Line {
    float largest = 0, mean = 0;
    float clear = 1;  ///< fraction of the line before the first z-score above kEdgeZScore
  };
  SIMPLEXSEG_HD Line line_to(int voxel) const {
    const std::array<float, 3>& from = balls[nearest[voxel]].index;
    const int at[3]{voxel % grid.size[0], voxel / grid.row() % grid.size[1], voxel / grid.plane()};
    float direction[3], longest = 0;
    for (int a = 0; a < 3; ++a) {
      direction[a] = static_cast<float>(at[a]) - from[a];
      longest = larger(std::fabs(direction[a]), longest);
    }
    const int steps = smaller(larger(static_cast<int>(longest + 0.5f), 1), kMostSteps);
    const float step = 1 / static_cast<float>(steps);
    Line line;
    for (int s = 1; s <= steps; ++s) {
      const float t = static_cast<float>(s) * step;
      int v = 0;
      for (int a = 0; a < 3; ++a)
        v += grid.stride(a) * smaller(larger(static_cast<int>(from[a] + t * direction[a] + 0.5f), 0), grid.size[a] - 1);
      const float here = image_z_score(v);
      line.largest = larger(here, line.largest);
      line.mean += step * here;
      if (line.clear == 1 && here > kEdgeZScore) line.clear = t - step;
    }
    return line;
  }

  /// Calls set(f, value) for each feature f of a voxel.
  template <class Set>
  SIMPLEXSEG_HD void fill(int v, const Set& set) const {
    const float in = inside[v], out = outside[v];
    const float y = smaller(larger(walker[v], kLeastWalkerProbability), 1 - kLeastWalkerProbability);
    const float distance = std::sqrt(from_inside[v]), scales = distance / scale_mm;
    const Line line = line_to(v);
    set(kAppearance, score[v]);
    set(kGeodesicRatio, use_geodesic ? (out - in) / (out + in + 1e-3f) : 0.0f);
    set(kRandomWalk, use_random_walk ? std::log(y / (1 - y)) : 0.0f);
    set(kDistanceInScales, std::log(scales + 0.1f));
    set(kDistanceInRadii, std::log(distance / balls[nearest[v]].radius_mm + 0.1f));
    set(kOutsideDistance, std::log(smaller(std::sqrt(from_outside[v]) / scale_mm, kFarthestMark) + 0.1f));
    set(kEdgesInside, std::log(edges_in[v] + 0.05f));
    set(kEdgesOutside, std::log(smaller(edges_out[v], 100.0f) + 0.05f));
    set(kZScore, image_z_score(v));
    for (int s = 1; s < 3; ++s) set(kZScore + s, z_score(s, smoothed[s - 1][v]));
    set(kLineLargest, line.largest);
    set(kLineMean, line.mean);
    set(kLineClear, line.clear);
    set(kLineClearLength, std::log(line.clear * scales + 0.1f));
    set(kScaleInRadii, std::log(scale_mm / radius_mm));
    set(kBlocksPerScale, std::log(scale_mm / least_spacing_mm));
    set(kNoise, std::log(noise));
    set(kSpread, -std::log(inverse_deviation));
    set(kShellContrast, shell_contrast);
    set(kMarkCount, std::log(static_cast<float>(marks)));
  }
};

}  // namespace simplexseg
