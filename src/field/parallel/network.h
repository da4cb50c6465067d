// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <vector>

#include "core/expect.h"
#include "field/parallel/executor.h"
#include "field/prior_network.h"

namespace simplexseg {

/// PriorNetwork in the memory of an executor; all layers are padded with zeros to kMostWidth.
struct NetworkView {
  static constexpr int kMostLayers = 6;
  const float* numbers;  ///< centres, scales; weights of each layer, row by row, and its biases
  int layers;
  int in[kMostLayers], out[kMostLayers];  ///< numbers of inputs and outputs without padding

  /// Writes the probabilities, 0..255 for 0..1, of cells v ... v + kLanes - 1, whose features are features.fill(cell,
  /// set).
  template <int kLanes, class Features>
  SIMPLEXSEG_HD void evaluate(const Features& features, int v, std::uint8_t (&probability)[kLanes]) const {
    float x[kMostWidth][kLanes]{}, y[kMostWidth][kLanes];
    for (int l = 0; l < kLanes; ++l) features.fill(v + l, [&](int f, float value) { x[f][l] = value; });
    SIMPLEXSEG_UNROLL_ALL
    for (int f = 0; f < Features::kFeatures; ++f)
      for (int l = 0; l < kLanes; ++l) x[f][l] = normalised_input(x[f][l], numbers[f], numbers[kMostWidth + f]);
    const float* at = numbers + 2 * kMostWidth;
    for (int layer = 0; layer < layers; ++layer) {
      const bool last = layer + 1 == layers;
      // On a device all loops are unrolled, so that x and y are registers.
      const int outputs = kLanes == 1 ? kMostWidth : out[layer], inputs = kLanes == 1 ? kMostWidth : in[layer];
      SIMPLEXSEG_UNROLL_ALL
      for (int o = 0; o < outputs; ++o) {
        float sum[kLanes];
        for (int l = 0; l < kLanes; ++l) sum[l] = at[kMostWidth * kMostWidth + o];
        SIMPLEXSEG_UNROLL_ALL
        for (int i = 0; i < inputs; ++i)
          for (int l = 0; l < kLanes; ++l) sum[l] += at[o * kMostWidth + i] * x[i][l];
        for (int l = 0; l < kLanes; ++l) y[o][l] = last || sum[l] > 0 ? sum[l] : 0;
      }
      SIMPLEXSEG_UNROLL_ALL
      for (int o = 0; o < outputs; ++o)
        for (int l = 0; l < kLanes; ++l) x[o][l] = y[o][l];
      at += kMostWidth * kMostWidth + kMostWidth;
    }
    for (int l = 0; l < kLanes; ++l) probability[l] = network_output(x[0][l]);
  }
};

/// Writes the probabilities of cells, 0..255 for 0..1, from their features.
template <class Features>
struct OutputOfNetwork {
  Features features;
  NetworkView network;
  std::uint8_t* to;
  template <int kLanes>
  SIMPLEXSEG_HD void run(int v) const {
    std::uint8_t probability[kLanes];
    network.evaluate<kLanes>(features, v, probability);
    for (int l = 0; l < kLanes; ++l) to[v + l] = probability[l];
  }
};

template <class Executor>
class ParallelNetwork {
 public:
  ParallelNetwork(const Executor& executor, const PriorNetwork& network)
      : view_{nullptr, static_cast<int>(network.layers.size()), {}, {}} {
    SIMPLEXSEG_EXPECT(view_.layers <= NetworkView::kMostLayers);
    std::vector<float> numbers(2 * kMostWidth);
    for (int f = 0; f < network.features(); ++f) {
      numbers[f] = network.centre[f];
      numbers[kMostWidth + f] = network.scale[f];
    }
    for (const PriorNetwork::Layer& layer : network.layers) {
      const std::size_t first = numbers.size(), l = &layer - network.layers.data();
      view_.in[l] = layer.in, view_.out[l] = layer.out;
      numbers.resize(first + kMostWidth * kMostWidth + kMostWidth);
      for (int o = 0; o < layer.out; ++o) {
        for (int i = 0; i < layer.in; ++i) numbers[first + o * kMostWidth + i] = layer.weight[o * layer.in + i];
        numbers[first + kMostWidth * kMostWidth + o] = layer.bias[o];
      }
    }
    numbers_ = executor.template copy_of<float>(numbers);
    view_.numbers = numbers_.data();
  }
  const NetworkView& view() const { return view_; }
  std::size_t bytes() const { return numbers_.bytes(); }

 private:
  NetworkView view_;
  typename Executor::template Array<float> numbers_;
};

}  // namespace simplexseg
