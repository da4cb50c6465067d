// SPDX-License-Identifier: Apache-2.0
#include "learn_prior/learner.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "field/parallel/cpu_executor.h"
#include "field/parallel/network.h"

namespace simplexseg {
namespace {

constexpr float kRate = 2e-3f, kDecay = 1e-2f;
constexpr float kJitter = 0.1f;   // noise added to features, in standard deviations
constexpr float kMaxWeight = 20;  // largest weight of a sample

}  // namespace

Learner::Learner(const std::vector<Sample>& samples, std::vector<int> widths, unsigned start)
    : widths_(std::move(widths)), random_(start) {
  const int n = widths_.front();
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(n), square = mean;
  double total = 0;
  for (const Sample& s : samples) {
    total += s.weight;
    for (int f = 0; f < n; ++f) {
      mean[f] += static_cast<double>(s.weight) * s.feature[f];
      square[f] += static_cast<double>(s.weight) * s.feature[f] * s.feature[f];
    }
  }
  mean /= total;
  centre_ = mean.cast<float>();
  scale_ = ((square / total).array() - mean.array().square()).max(1e-6).sqrt().inverse().cast<float>();
  for (std::size_t l = 0; l + 1 < widths_.size(); ++l) {
    Eigen::MatrixXf w(widths_[l + 1], widths_[l] + 1);  // the last column: bias
    for (float& x : w.reshaped()) x = normal_(random_) * std::sqrt(2.0f / static_cast<float>(widths_[l]));
    w.rightCols(1).setZero();
    weight_.push_back(w);
    first_.emplace_back(Eigen::MatrixXf::Zero(w.rows(), w.cols()));
    second_.emplace_back(first_.back());
  }
}

void Learner::learn(const std::vector<Sample>& samples, int epochs) {
  constexpr int batch = 256;
  std::vector<std::size_t> order(samples.size());
  for (std::size_t s = 0; s < order.size(); ++s) order[s] = s;
  const double steps = static_cast<double>(epochs) * static_cast<double>(samples.size()) / batch;
  for (int epoch = 0; epoch < epochs; ++epoch) {
    std::shuffle(order.begin(), order.end(), random_);
    for (std::size_t s = 0; s + batch <= samples.size(); s += batch) {
      const std::vector<Eigen::MatrixXf> layers = forward(samples, {order.data() + s, batch});
      Eigen::MatrixXf slope(1, batch);
      for (int c = 0; c < batch; ++c) {
        const Sample& one = samples[order[s + c]];
        const float p = 1 / (1 + std::exp(-layers.back()(0, c)));
        slope(0, c) = std::min(one.weight, kMaxWeight) * (p - one.positive) / batch;
      }
      ++step_;
      backward(layers, slope, static_cast<float>(0.5 + 0.5 * std::cos(std::numbers::pi * step_ / steps)));
    }
  }
}

PriorNetwork Learner::network() const {
  PriorNetwork network;
  network.centre.assign(centre_.begin(), centre_.end());
  network.scale.assign(scale_.begin(), scale_.end());
  for (const Eigen::MatrixXf& w : weight_) {
    PriorNetwork::Layer& layer = network.layers.emplace_back();
    layer.in = static_cast<int>(w.cols()) - 1;
    layer.out = static_cast<int>(w.rows());
    for (int o = 0; o < layer.out; ++o) {
      for (int i = 0; i < layer.in; ++i) layer.weight.push_back(w(o, i));
      layer.bias.push_back(w(o, layer.in));
    }
  }
  return network;
}

std::vector<Eigen::MatrixXf> Learner::forward(const std::vector<Sample>& samples, std::span<const std::size_t> which) {
  const int n = widths_.front(), count = static_cast<int>(which.size());
  std::vector<Eigen::MatrixXf> layers{Eigen::MatrixXf(n, count)};
  for (int c = 0; c < count; ++c)
    for (int f = 0; f < n; ++f) {
      const float x = (samples[which[c]].feature[f] - centre_[f]) * scale_[f];
      layers[0](f, c) = std::clamp(x, -kMostDeviations, kMostDeviations) + kJitter * normal_(random_);
    }
  for (std::size_t l = 0; l < weight_.size(); ++l) {
    const Eigen::MatrixXf& w = weight_[l];
    Eigen::MatrixXf y = (w.leftCols(w.cols() - 1) * layers[l]).colwise() + w.rightCols(1).col(0);
    if (l + 1 < weight_.size()) y = y.cwiseMax(0.0f);
    layers.push_back(std::move(y));
  }
  return layers;
}

void Learner::backward(const std::vector<Eigen::MatrixXf>& layers, Eigen::MatrixXf slope, float cooling) {
  const float rate = kRate * cooling, n = static_cast<float>(step_);
  const float first = 1 - std::pow(0.9f, n), second = 1 - std::pow(0.999f, n);
  for (std::size_t l = weight_.size(); l-- > 0;) {
    Eigen::MatrixXf& w = weight_[l];
    const auto columns = w.cols() - 1;
    Eigen::MatrixXf gradient(w.rows(), w.cols());
    gradient.leftCols(columns) = slope * layers[l].transpose();
    gradient.rightCols(1) = slope.rowwise().sum();
    if (l > 0)
      slope =
          (w.leftCols(columns).transpose() * slope).cwiseProduct((layers[l].array() > 0).cast<float>().matrix()).eval();
    first_[l] = 0.9f * first_[l] + 0.1f * gradient;
    second_[l] = 0.999f * second_[l] + 0.001f * gradient.cwiseAbs2();
    w.leftCols(columns) *= 1 - rate * kDecay;
    w.array() -= rate * (first_[l].array() / first) / ((second_[l].array() / second).sqrt() + 1e-8f);
  }
}

PriorNetwork joined(const PriorNetwork& a, const PriorNetwork& b) {
  if (a.layers.size() != b.layers.size() || a.features() != b.features())
    throw Error("cannot join the networks", "their layers differ", "give two networks of the same layout");
  PriorNetwork both = a;
  for (std::size_t l = 0; l < a.layers.size(); ++l) {
    const PriorNetwork::Layer &one = a.layers[l], &two = b.layers[l];
    const bool first = l == 0, last = l + 1 == a.layers.size();
    PriorNetwork::Layer& layer = both.layers[l];
    layer.in = first ? one.in : one.in + two.in;
    layer.out = last ? one.out : one.out + two.out;
    layer.weight.assign(static_cast<std::size_t>(layer.in) * layer.out, 0.0f);
    layer.bias.assign(layer.out, 0.0f);
    const float share = last ? 0.5f : 1.0f;
    for (const bool second : {false, true}) {
      const PriorNetwork::Layer& from = second ? two : one;
      const int to_out = second && !last ? one.out : 0, to_in = second && !first ? one.in : 0;
      for (int o = 0; o < from.out; ++o) {
        layer.bias[to_out + o] += share * from.bias[o];
        for (int i = 0; i < from.in; ++i) {
          float w = share * from.weight[static_cast<std::size_t>(o) * from.in + i];
          if (first && second) {
            layer.bias[to_out + o] += w * (a.centre[i] - b.centre[i]) * b.scale[i];
            w *= b.scale[i] / a.scale[i];
          }
          layer.weight[static_cast<std::size_t>(to_out + o) * layer.in + to_in + i] += w;
        }
      }
    }
  }
  return both;
}

namespace {

struct FeaturesOfSamples {
  static constexpr int kFeatures = kMostWidth;  ///< a network ignores those that it does not have
  const Sample* samples;
  template <class Set>
  void fill(int sample, const Set& set) const {
    for (int f = 0; f < kFeatures; ++f) set(f, samples[sample].feature[f]);
  }
};
}  // namespace

Judgement judge(const PriorNetwork& network, const std::vector<Sample>& samples) {
  std::vector<std::uint8_t> output(samples.size());
  const CpuFieldExecutor executor;
  const ParallelNetwork<CpuFieldExecutor> on_executor(executor, network);
  executor.each_lanes(static_cast<int>(samples.size()),
                      OutputOfNetwork<FeaturesOfSamples>{{samples.data()}, on_executor.view(), output.data()});
  Judgement sum{0, 0};
  double weight = 0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    const double p = (output[s] + 0.5) / 256, w = samples[s].weight;
    const bool positive = samples[s].positive > 0.5f;
    sum.loss -= w * std::log(positive ? p : 1 - p);
    sum.wrong += (output[s] > 127) != positive ? w : 0;
    weight += w;
  }
  return {sum.loss / weight, sum.wrong / weight};
}

}  // namespace simplexseg
