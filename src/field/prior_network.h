// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cmath>
#include <cstdint>
#include <iosfwd>
#include <string>
#include <vector>

#include "core/vec3.h"

namespace simplexseg {

/// Largest number of values of a cell at any layer.
inline constexpr int kMostWidth = 32;
/// Deviations: a feature that is farther than this from all that was learned says no more.
inline constexpr float kMostDeviations = 4;

/// What of a feature goes into a network.
SIMPLEXSEG_HD float seen_by_network(float feature, float centre, float scale) {
  return smaller(larger((feature - centre) * scale, -kMostDeviations), kMostDeviations);
}
/// A network's answer, 0..255 for 0..1, from the number of its last layer.
SIMPLEXSEG_HD std::uint8_t answer_of_network(float x) {
  return static_cast<std::uint8_t>(255 / (1 + std::exp(-x)) + 0.5f);
}

/// A small network of a voxel's features: layers of weights with max(x, 0) between them and a sigmoid at the end.
/// Learned by tests/benchmarks/learn_prior.
struct PriorNetwork {
  struct Layer {
    int in = 0, out = 0;
    std::vector<float> weight;  ///< out x in, row by row
    std::vector<float> bias;    ///< out
  };
  std::vector<float> centre, scale;  ///< of each feature: (feature - centre) * scale, bounded by 4, goes in
  std::vector<Layer> layers;

  int features() const { return static_cast<int>(centre.size()); }

  /// All numbers, in a form that read() reads.
  std::string text() const;
  /// Throws Error for anything else than what text() writes.
  static PriorNetwork read(std::istream& in);
};

/// What the prior is made with.
struct PriorNetworks {
  PriorNetwork marks;   ///< of MarkView
  PriorNetwork update;  ///< of UpdateView

  /// The one after the other, in a form that parse() reads.
  std::string text() const;
  /// Throws Error for anything else than what text() writes, and for networks of other features.
  static PriorNetworks parse(const std::string& text);
};

/// Those that the program comes with.
const PriorNetworks& learned_networks();

}  // namespace simplexseg
