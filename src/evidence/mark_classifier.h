// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <span>
#include <vector>

#include "evidence/run_jobs.h"

namespace simplexseg {

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
                 const Settings& settings);
  /// About +1 for what looks like the inside, -1 for what looks like the outside, 0 for what looks like neither.
  void score(const FeatureLists& features, std::span<float> out, const RunJobs& run) const;

 private:
  std::size_t features_;
  std::vector<float> frequency_, phase_, weight_;  ///< of each term
};

}  // namespace simplexseg
