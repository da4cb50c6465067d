// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "core/vec3.h"

namespace simplexseg {

/// Largest number of inputs or outputs of a layer.
inline constexpr int kMostWidth = 32;
/// Bound of the inputs, standard deviations of the training data.
inline constexpr float kMostDeviations = 4;

/// Input of a network from a feature.
SIMPLEXSEG_HD float normalised_input(float feature, float centre, float scale) {
  return smaller(larger((feature - centre) * scale, -kMostDeviations), kMostDeviations);
}
/// Output of a network: sigmoid of the value of its last layer, 0..255 for 0..1.
SIMPLEXSEG_HD std::uint8_t network_output(float x) {
  return static_cast<std::uint8_t>(255 / (1 + std::exp(-x)) + 0.5f);
}

/// Network from the features of a cell to a probability: linear layers with max(x, 0) between them, and a sigmoid.
/// Trained by tests/benchmarks/learn_prior.
struct PriorNetwork {
  struct Layer {
    int in = 0, out = 0;
    std::vector<float> weight;  ///< out x in, row by row
    std::vector<float> bias;    ///< out
  };
  std::vector<std::string> feature_names;
  std::vector<float> centre, scale;  ///< a value for each feature, normalised_input()
  std::vector<Layer> layers;

  int features() const { return static_cast<int>(centre.size()); }

  /// All numbers as text.
  std::string text() const;
  /// Reads the output of text(); throws Error for any other input.
  static PriorNetwork read(std::istream& in);
};

/// Networks of the prior.
struct PriorNetworks {
  PriorNetwork marks;   ///< of MarkView
  PriorNetwork update;  ///< of UpdateView

  /// Both networks as text, in this order.
  std::string text() const;
  /// Reads the output of text(); throws Error for any other input, and for networks of other features.
  static PriorNetworks parse(const std::string& text);
};

/// Networks of the program.
const PriorNetworks& learned_networks();

}  // namespace simplexseg
