// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "core/vec3.h"

namespace simplexseg {

/// cos(2 pi t) with an error of at most 1.1e-3: two parabolas and a correction.
SIMPLEXSEG_HD float cosine_of_turns(float t) {
  t = t - std::floor(t + 0.5f);          // -0.5 .. 0.5
  const float u = 0.25f - std::fabs(t);  // cos(2 pi t) = sin(2 pi u), u in -0.25 .. 0.25
  const float s = 8 * u - 16 * u * std::fabs(u);
  return s * (0.775f + 0.225f * std::fabs(s));
}

/// Random Fourier features: cosine_of_turns(phase + frequency . features).
struct FourierTerms {
  std::vector<float> frequency;  ///< terms x features, row by row
  std::vector<float> phase;      ///< a value for each term, turns
};

/// Features of all voxels of a box, one list per feature, with mean 0 and standard deviation 1.
using FeatureLists = std::vector<std::vector<float>>;

/// Classifier of cells, inside or outside, trained with marked cells: ridge regression to +1 and -1 on random Fourier
/// features, an approximation of a Gaussian kernel. Both classes have the same total weight. Source: Rahimi and Recht
/// 2007, Random Features for Large-Scale Kernel Machines.
struct ClassifierSettings {
  int terms = 128;
  double kernel_width = 3;  ///< standard deviation of the kernel, in standard deviations of the features
  double ridge = 0.01;
};
struct ClassifierSample {
  int voxel;
  float weight;
};
/// Random Fourier features; every call returns equal numbers.
FourierTerms fourier_terms(const ClassifierSettings& settings, int features);
/// Weights of the terms: solution of the ridge regression with these normal equations. `gram`: lower triangle.
std::vector<float> term_weights(Eigen::MatrixXf gram, const Eigen::VectorXf& right, const ClassifierSettings& settings);

}  // namespace simplexseg
