// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <random>
#include <span>
#include <vector>

#include "evidence/prior_network.h"
#include "learn_prior/samples.h"

namespace simplexseg {

/// Learns one network: Adam (Kingma and Ba 2015) on the weighted logistic loss.
class Learner {
 public:
  /// `widths`: of the features, the hidden layers, and 1. The same `start`, the same network.
  Learner(const std::vector<Sample>& samples, std::vector<int> widths, unsigned start);
  void learn(const std::vector<Sample>& samples, int epochs);
  PriorNetwork network() const;

 private:
  std::vector<Eigen::MatrixXf> forward(const std::vector<Sample>& samples, std::span<const std::size_t> which);
  void backward(const std::vector<Eigen::MatrixXf>& layers, Eigen::MatrixXf slope, float cooling);

  std::vector<int> widths_;
  Eigen::VectorXf centre_, scale_;
  std::vector<Eigen::MatrixXf> weight_, first_, second_;  // the last column of each: bias
  double step_ = 0;
  std::mt19937 random_;
  std::normal_distribution<float> normal_{0, 1};
};

/// Side by side, the features as the first has them centred and scaled: the mean of what the two say before the last
/// sigmoid, which is steadier than either. Throws Error where their layers are not as many.
PriorNetwork joined(const PriorNetwork& a, const PriorNetwork& b);

/// Weighted mean of the logistic loss, and share of the samples on the wrong side.
struct Judgement {
  double loss, wrong;
};
Judgement judge(const PriorNetwork& network, const std::vector<Sample>& samples);

}  // namespace simplexseg
