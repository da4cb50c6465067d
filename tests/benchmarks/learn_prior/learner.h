// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Core>
#include <random>
#include <span>
#include <vector>

#include "field/prior_network.h"
#include "learn_prior/samples.h"

namespace simplexseg {

/// Trains one network with Adam (Kingma and Ba 2015) on the weighted logistic loss.
class Learner {
 public:
  /// `widths`: number of features, widths of the hidden layers, 1. The network is a function of the seed `start`.
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

/// Network whose output before the last sigmoid is the mean of those of two networks, which is more robust than either.
/// Centre and scale of the features are those of the first. Throws Error if their numbers of layers differ.
PriorNetwork joined(const PriorNetwork& a, const PriorNetwork& b);

/// Weighted mean of the logistic loss, and weighted share of misclassified samples.
struct Judgement {
  double loss, wrong;
};
Judgement judge(const PriorNetwork& network, const std::vector<Sample>& samples);

}  // namespace simplexseg
