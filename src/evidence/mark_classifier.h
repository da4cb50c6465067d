// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <span>
#include <vector>

#include "core/vec3.h"
#include "evidence/run_jobs.h"

namespace simplexseg {

/// cos(2 pi t) to 1e-3: two parabolas and a correction.
SIMPLEXSEG_HD float cosine_of_turns(float t) {
  t = t - std::floor(t + 0.5f);          // -0.5 .. 0.5
  const float u = 0.25f - std::fabs(t);  // cos(2 pi t) = sin(2 pi u), u in -0.25 .. 0.25
  const float s = 8 * u - 16 * u * std::fabs(u);
  return s * (0.775f + 0.225f * std::fabs(s));
}

/// cosine_of_turns(phase + frequency times features) is what a term says.
struct FourierTerms {
  std::vector<float> frequency;  ///< terms x features, row by row
  std::vector<float> phase;      ///< of each term
};

/// Values of all voxels of a box, one list for each feature, about zero with deviation 1.
using FeatureLists = std::vector<std::vector<float>>;

/// What tells inside from outside, learned from marked voxels: ridge regression to +1 and -1 on random Fourier features
/// (Rahimi and Recht 2007, Random Features for Large-Scale Kernel Machines), a Gaussian kernel. Either side has the
/// same weight in all, whatever its number of voxels.
class MarkClassifier {
 public:
  struct Settings {
    int terms = 128;
    double kernel_width = 3;  ///< in deviations of the features
    double ridge = 0.01;
  };
  /// `inside`, `outside`: voxels and their weights, each list not empty.
  struct Sample {
    int voxel;
    float weight;
  };
  MarkClassifier(const FeatureLists& features, std::span<const Sample> inside, std::span<const Sample> outside,
                 const Settings& settings, const RunJobs& run);
  /// About +1 for what looks like the inside, -1 for what looks like the outside, 0 for what looks like neither.
  void score(const FeatureLists& features, std::span<float> out, const RunJobs& run) const;

 private:
  std::size_t features_;
  FourierTerms terms_;
  std::vector<float> weight_;  ///< of each term
};
/// The same numbers every time.
FourierTerms fourier_terms(const MarkClassifier::Settings& settings, int features);
/// The weight of each term: the solution of the ridge regression with these equations, of which the lower half is read.
std::vector<float> term_weights(Eigen::MatrixXf gram, const Eigen::VectorXf& right,
                                const MarkClassifier::Settings& settings);

}  // namespace simplexseg
