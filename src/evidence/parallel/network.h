// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "evidence/parallel/executor.h"
#include "evidence/prior_network.h"

namespace simplexseg {

/// A PriorNetwork in the executor's memory, all layers kMostWidth wide, with zeros.
struct NetworkView {
  const float* numbers;  ///< centres, scales; of each layer its weights, row by row, and its biases
  int layers;

  /// Takes features and gives them to a network.
  struct Input {
    const float* numbers;
    float* x;
    SIMPLEXSEG_HD void operator()(int feature, float value) const {
      x[feature] = seen_by_network(value, numbers[feature], numbers[kMostWidth + feature]);
    }
  };

  /// What it says of voxel v, whose features features.fill(v, set) gives: 0..255 for 0..1.
  template <class Features>
  SIMPLEXSEG_HD std::uint8_t answer(const Features& features, int v) const {
    float x[kMostWidth]{}, y[kMostWidth];
    features.fill(v, Input{numbers, x});
    const float* at = numbers + 2 * kMostWidth;
    for (int l = 0; l < layers; ++l) {
      const bool last = l + 1 == layers;
      SIMPLEXSEG_UNROLL_ALL
      for (int o = 0; o < kMostWidth; ++o) {
        float sum = at[kMostWidth * kMostWidth + o];
        SIMPLEXSEG_UNROLL_ALL
        for (int i = 0; i < kMostWidth; ++i) sum += at[o * kMostWidth + i] * x[i];
        y[o] = last || sum > 0 ? sum : 0;
      }
      SIMPLEXSEG_UNROLL_ALL
      for (int o = 0; o < kMostWidth; ++o) x[o] = y[o];
      at += kMostWidth * kMostWidth + kMostWidth;
    }
    return answer_of_network(x[0]);
  }
};

template <class Executor>
class ParallelNetwork {
 public:
  ParallelNetwork(const Executor& executor, const PriorNetwork& network)
      : layers_(static_cast<int>(network.layers.size())) {
    std::vector<float> numbers(2 * kMostWidth);
    for (int f = 0; f < network.features(); ++f) {
      numbers[f] = network.centre[f];
      numbers[kMostWidth + f] = network.scale[f];
    }
    for (const PriorNetwork::Layer& layer : network.layers) {
      const std::size_t first = numbers.size();
      numbers.resize(first + kMostWidth * kMostWidth + kMostWidth);
      for (int o = 0; o < layer.out; ++o) {
        for (int i = 0; i < layer.in; ++i) numbers[first + o * kMostWidth + i] = layer.weight[o * layer.in + i];
        numbers[first + kMostWidth * kMostWidth + o] = layer.bias[o];
      }
    }
    numbers_ = executor.template copy_of<float>(numbers);
  }
  NetworkView view() const { return {numbers_.data(), layers_}; }
  std::size_t bytes() const { return numbers_.bytes(); }

 private:
  int layers_;
  typename Executor::template Array<float> numbers_;
};

}  // namespace simplexseg
