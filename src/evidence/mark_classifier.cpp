// SPDX-License-Identifier: Apache-2.0
#include "evidence/mark_classifier.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

namespace simplexseg {
namespace {

/// Numbers that are the same on every machine (Steele et al. 2014, SplitMix64).
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

FourierTerms fourier_terms(const MarkClassifier::Settings& settings, int features) {
  FourierTerms terms{std::vector<float>(std::size_t(settings.terms) * features), std::vector<float>(settings.terms)};
  Random random;
  const double turn = 2 * std::numbers::pi;
  for (float& f : terms.frequency) f = static_cast<float>(random.normal() / settings.kernel_width / turn);
  for (float& p : terms.phase) p = static_cast<float>(random.uniform());
  return terms;
}

MarkClassifier::MarkClassifier(const FeatureLists& features, std::span<const Sample> inside,
                               std::span<const Sample> outside, const Settings& settings, const RunJobs& run)
    : features_(features.size()), terms_(fourier_terms(settings, static_cast<int>(features.size()))) {
  Eigen::MatrixXf gram = Eigen::MatrixXf::Zero(settings.terms, settings.terms);
  Eigen::VectorXf right = Eigen::VectorXf::Zero(settings.terms);
  const Eigen::MatrixXf of_feature =
      Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          terms_.frequency.data(), settings.terms, static_cast<Eigen::Index>(features_));
  for (const bool in : {true, false}) {
    const std::span<const Sample> samples = in ? inside : outside;
    double total = 0;
    for (const Sample& s : samples) total += s.weight;
    Eigen::MatrixXf rows(settings.terms, samples.size());
    constexpr int together = 64;
    const int count = static_cast<int>(samples.size());
    run((count + together - 1) / together, [&](int job) {
      const int first = job * together, last = std::min(count, first + together);
      Eigen::VectorXf angle(settings.terms);
      for (int s = first; s < last; ++s) {
        angle = Eigen::Map<const Eigen::VectorXf>(terms_.phase.data(), settings.terms);
        for (std::size_t f = 0; f < features_; ++f)
          angle += features[f][samples[s].voxel] * of_feature.col(static_cast<Eigen::Index>(f));
        const float scale = std::sqrt(static_cast<float>(samples[s].weight / total) * 2 / settings.terms);
        for (int t = 0; t < settings.terms; ++t) rows(t, s) = scale * cosine_of_turns(angle[t]);
      }
    });
    for (int s = 0; s < count; ++s) {
      const float root = std::sqrt(static_cast<float>(samples[s].weight / total));
      right += (in ? root : -root) * rows.col(s);
    }
    gram.selfadjointView<Eigen::Lower>().rankUpdate(rows);
  }
  weight_ = term_weights(std::move(gram), right, settings);
}

std::vector<float> term_weights(Eigen::MatrixXf gram, const Eigen::VectorXf& right,
                                const MarkClassifier::Settings& settings) {
  gram.diagonal().array() += static_cast<float>(settings.ridge);
  const Eigen::VectorXf w = gram.selfadjointView<Eigen::Lower>().llt().solve(right);
  std::vector<float> weights(settings.terms);
  for (int t = 0; t < settings.terms; ++t) weights[t] = w[t] * std::sqrt(2.0f / settings.terms);
  return weights;
}

void MarkClassifier::score(const FeatureLists& features, std::span<float> out, const RunJobs& run) const {
  const int n = static_cast<int>(out.size());
  run((n + indices_a_block - 1) / indices_a_block, [&](int block) {
    const int first = block * indices_a_block, last = std::min(n, first + indices_a_block);
    constexpr int lanes = 64;
    float angle[lanes], sum[lanes];
    for (int start = first; start < last; start += lanes) {
      const int m = std::min(lanes, last - start);
      std::fill_n(sum, lanes, 0.0f);
      for (std::size_t t = 0; t < weight_.size(); ++t) {
        std::fill_n(angle, lanes, terms_.phase[t]);
        for (std::size_t f = 0; f < features_; ++f) {
          const float w = terms_.frequency[t * features_ + f], *const x = features[f].data() + start;
          for (int l = 0; l < m; ++l) angle[l] += w * x[l];
        }
        for (int l = 0; l < lanes; ++l) sum[l] += weight_[t] * cosine_of_turns(angle[l]);
      }
      std::copy_n(sum, m, out.data() + start);
    }
  });
}

}  // namespace simplexseg
