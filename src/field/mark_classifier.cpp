// SPDX-License-Identifier: Apache-2.0
#include "field/mark_classifier.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace simplexseg {
namespace {

/// Random numbers that are equal on all machines. Source: Steele et al. 2014, SplitMix64.
class Random {
 public:
  double uniform() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
  }
  /// Standard normal, as the sum of twelve uniform numbers.
  double normal() {
    double sum = -6;
    for (int k = 0; k < 12; ++k) sum += uniform();
    return sum;
  }

 private:
  std::uint64_t state_ = 1;
};

}  // namespace

FourierTerms fourier_terms(const ClassifierSettings& settings, int features) {
  FourierTerms terms{std::vector<float>(std::size_t(settings.terms) * features), std::vector<float>(settings.terms)};
  Random random;
  const double turn = 2 * std::numbers::pi;
  for (float& f : terms.frequency) f = static_cast<float>(random.normal() / settings.kernel_width / turn);
  for (float& p : terms.phase) p = static_cast<float>(random.uniform());
  return terms;
}

std::vector<float> term_weights(Eigen::MatrixXf gram, const Eigen::VectorXf& right,
                                const ClassifierSettings& settings) {
  gram.diagonal().array() += static_cast<float>(settings.ridge);
  const Eigen::VectorXf w = gram.selfadjointView<Eigen::Lower>().llt().solve(right);
  std::vector<float> weights(settings.terms);
  for (int t = 0; t < settings.terms; ++t) weights[t] = w[t] * std::sqrt(2.0f / settings.terms);
  return weights;
}

}  // namespace simplexseg
