// SPDX-License-Identifier: Apache-2.0
#include "field/prior_network.h"
#include "field/parallel/cpu_executor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <sstream>

#include "core/error.h"
#include "field/mark_view.h"
#include "field/parallel/network.h"
#include "field/update_view.h"
#include "references.h"

namespace simplexseg {
namespace {

/// Network sigmoid(2 max(0, a - b) - max(0, b) + 0.5) with a, b = 2 (feature - 1).
PriorNetwork small_network() {
  PriorNetwork network;
  network.feature_names = {"first", "second"};
  network.centre = {1, 1};
  network.scale = {2, 2};
  network.layers = {{2, 2, {1, -1, 0, 1}, {0, 0}}, {2, 1, {2, -1}, {0.5f}}};
  return network;
}

struct TwoFeatures {
  static constexpr int kFeatures = 2;
  const std::array<float, 2>* voxels;
  template <class Set>
  void fill(int v, const Set& set) const {
    for (int f = 0; f < kFeatures; ++f) set(f, voxels[v][f]);
  }
};
std::vector<std::uint8_t> outputs(const PriorNetwork& network, const std::vector<std::array<float, 2>>& voxels,
                                  const RunJobs& run = run_serially()) {
  const CpuFieldExecutor executor(run);
  const ParallelNetwork<CpuFieldExecutor> on_executor(executor, network);
  std::vector<std::uint8_t> out(voxels.size());
  executor.each_lanes(static_cast<int>(voxels.size()),
                      OutputOfNetwork<TwoFeatures>{{voxels.data()}, on_executor.view(), out.data()});
  return out;
}

TEST(PriorNetwork, EvaluatesItsLayers) {
  std::vector<std::array<float, 2>> voxels;
  for (int v = 0; v < 100; ++v) voxels.push_back({0.02f * static_cast<float>(v), 1.5f - 0.01f * static_cast<float>(v)});
  const std::vector<std::uint8_t> out = outputs(small_network(), voxels);
  EXPECT_EQ(outputs(small_network(), voxels, run_in_reverse()), out);
  for (std::size_t v = 0; v < voxels.size(); ++v) {
    const double a = 2 * (voxels[v][0] - 1.0), b = 2 * (voxels[v][1] - 1.0);
    const double z = 2 * std::max(0.0, a - b) - std::max(0.0, b) + 0.5;
    EXPECT_NEAR(out[v], 255 / (1 + std::exp(-z)), 1) << v;
  }
}

TEST(PriorNetwork, FeaturesAreClampedToTheTrainingRange) {
  EXPECT_EQ(outputs(small_network(), {{3, 1}}), outputs(small_network(), {{300, 1}}));
  EXPECT_NE(outputs(small_network(), {{2, 1}}), outputs(small_network(), {{0.5f, 1}}));
}

PriorNetwork read(const std::string& text) {
  std::istringstream in(text);
  return PriorNetwork::read(in);
}

TEST(PriorNetwork, IsRestoredFromItsText) {
  const PriorNetwork again = read(small_network().text());
  EXPECT_EQ(again.feature_names, small_network().feature_names);
  EXPECT_EQ(again.centre, small_network().centre);
  ASSERT_EQ(again.layers.size(), 2u);
  EXPECT_EQ(again.layers[0].weight, small_network().layers[0].weight);
  EXPECT_EQ(again.layers[1].bias, small_network().layers[1].bias);
}

TEST(PriorNetwork, OtherTextIsRefused) {
  std::string cut = small_network().text();
  cut.resize(cut.size() / 2);
  for (const std::string& text : {std::string(), std::string("a network"), std::string("9999 1 1"),
                                  std::string("2 a b 1 1 1 1 0"), cut, std::string("2 a b 1 1 1 1 1 3 1 0 0 0 0")})
    EXPECT_THROW(read(text), Error) << text;
}

TEST(PriorNetworks, TheDefaultNetworksMatchTheirFeaturesAndAreRestoredFromText) {
  const PriorNetworks& own = learned_networks();
  EXPECT_EQ(own.marks.features(), MarkView::kFeatures);
  EXPECT_EQ(own.update.features(), UpdateView::kFeatures);
  const PriorNetworks again = PriorNetworks::parse(own.text());
  EXPECT_EQ(again.marks.layers[1].weight, own.marks.layers[1].weight);
  EXPECT_EQ(again.update.layers[1].weight, own.update.layers[1].weight);
}

TEST(PriorNetworks, ASingleOrSwappedNetworkIsRefused) {
  const PriorNetworks& own = learned_networks();
  EXPECT_THROW(PriorNetworks::parse(own.marks.text()), Error);
  EXPECT_THROW(PriorNetworks::parse(own.update.text() + own.marks.text()), Error);
}

TEST(PriorNetworks, NetworksOfOtherFeaturesAreRefused) {
  PriorNetworks other = learned_networks();
  std::swap(other.marks.feature_names[3], other.marks.feature_names[4]);
  EXPECT_THROW(PriorNetworks::parse(other.text()), Error);
  const auto& names = MarkView::kFeatureNames;
  EXPECT_EQ(std::set<std::string>(names.begin(), names.end()).size(), names.size());
}

}  // namespace
}  // namespace simplexseg
