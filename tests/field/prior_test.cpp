// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "field/parallel/cpu_executor.h"
#include "prior_reference.h"

namespace simplexseg {
namespace {

/// CpuFieldExecutor that counts operations that are slow on a device.
class Counting : public CpuFieldExecutor {
 public:
  mutable int launches = 0, waits = 0, uploads = 0;

  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    ++launches;
    CpuFieldExecutor::each(n, kernel);
  }
  template <class Kernel>
  void each_cell(const BoxGrid& grid, const Kernel& kernel) const {
    ++launches;
    CpuFieldExecutor::each_cell(grid, kernel);
  }
  template <class Kernel>
  void each_lanes(int n, const Kernel& kernel) const {
    ++launches;
    CpuFieldExecutor::each_lanes(n, kernel);
  }
  template <class Kernel>
  void each_cell_lanes(const BoxGrid& grid, const Kernel& kernel) const {
    ++launches;
    CpuFieldExecutor::each_cell_lanes(grid, kernel);
  }
  template <class Kernel>
  void all(const Kernel& kernel, const ReportProgress& progress = {}) const {
    ++launches;
    CpuFieldExecutor::all(kernel, progress);
  }
  template <class Kernel>
  void blocks(int count, const Kernel& kernel) const {
    ++launches;
    CpuFieldExecutor::blocks(count, kernel);
  }
  template <class Kernel>
  void sums_into(int n, const Kernel& kernel, double* to) const {
    ++launches;
    CpuFieldExecutor::sums_into(n, kernel, to);
  }
  template <class Kernel>
  void histogram(int n, const Kernel& kernel, int* count) const {
    ++launches;
    CpuFieldExecutor::histogram(n, kernel, count);
  }
  template <class T>
  void upload(std::span<const T> from, T* to) const {
    ++uploads;
    CpuFieldExecutor::upload(from, to);
  }
  template <class T>
  void download(const T* from, std::span<T> to) const {
    ++waits;
    CpuFieldExecutor::download(from, to);
  }
  template <class T>
  void receive(const Fetched<T>& fetched, std::span<T> to) const {
    ++waits;
    CpuFieldExecutor::receive(fetched, to);
  }
  template <class T>
  void copy(const T* from, T* to, std::size_t count) const {
    ++launches;
    CpuFieldExecutor::copy(from, to, count);
  }
  template <class T>
  void clear(T* at, std::size_t count) const {
    ++launches;
    CpuFieldExecutor::clear(at, count);
  }
};

struct Difference {
  double mean = 0;
  int most = 0, far = 0;  ///< `far`: number of voxels that differ by more than 5
};
Difference difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  Difference d;
  for (std::size_t v = 0; v < a.size(); ++v) {
    d.most = std::max(d.most, std::abs(a[v] - b[v]));
    d.far += std::abs(a[v] - b[v]) > 5;
    d.mean += std::abs(a[v] - b[v]) / static_cast<double>(a.size());
  }
  return d;
}

/// Output of a network for the features of each block, 0..255 for 0..1, in double.
std::vector<std::uint8_t> outputs(const PriorNetwork& network, const std::vector<std::vector<float>>& features) {
  std::vector<std::uint8_t> all(features.front().size());
  for (std::size_t v = 0; v < all.size(); ++v) {
    std::vector<double> x;
    for (std::size_t f = 0; f < features.size(); ++f)
      x.push_back(std::clamp((double{features[f][v]} - network.centre[f]) * network.scale[f], -4.0, 4.0));
    for (const PriorNetwork::Layer& layer : network.layers) {
      std::vector<double> y(layer.bias.begin(), layer.bias.end());
      for (int o = 0; o < layer.out; ++o) {
        for (int i = 0; i < layer.in; ++i) y[o] += double{layer.weight[o * layer.in + i]} * x[i];
        if (&layer != &network.layers.back()) y[o] = std::max(y[o], 0.0);
      }
      x = y;
    }
    all[v] = static_cast<std::uint8_t>(255 / (1 + std::exp(-x[0])) + 0.5);
  }
  return all;
}

/// Number of blocks at which two features differ by more than `most`, without those at which skip(v).
template <class Skip>
int differing(const std::vector<float>& a, const std::vector<float>& b, double most, const Skip& skip) {
  int count = 0;
  for (int v = 0; v < static_cast<int>(a.size()); ++v) count += !skip(v) && !(std::fabs(a[v] - b[v]) <= most);
  return count;
}

TEST(Prior, FeaturesOfAllMarksEqualTheReference) {
  const CpuFieldExecutor executor;
  for (const Named& named : stories()) {
    const auto prior = named.story.computed(executor);
    Reference reference(named.story);
    const PriorFeatures& found = prior.features();
    ASSERT_EQ(found.constraints, reference.constraints()) << named.name;
    const std::vector<std::vector<float>> expected = reference.mark_features();
    ASSERT_EQ(found.marks.size(), expected.size());
    for (int f = 0; f < static_cast<int>(expected.size()); ++f) {
      const bool of_nearest = f == 4 || (f >= 11 && f <= 14);
      const auto skip = [&](int v) { return of_nearest && reference.is_between_balls(v); };
      EXPECT_EQ(differing(found.marks[f], expected[f], 0.01, skip), 0) << named.name << ", feature " << f;
    }
  }
}

TEST(Prior, FeaturesOfNewMarksEqualTheReference) {
  const CpuFieldExecutor executor;
  int with_new_marks = 0;
  for (const Named& named : stories()) {
    const auto prior = named.story.computed(executor);
    const PriorFeatures& found = prior.features();
    ASSERT_EQ(found.update.empty(), named.story.new_balls().empty()) << named.name;
    ASSERT_EQ(found.near_inside.empty(), named.story.new_balls().empty()) << named.name;
    if (named.story.new_balls().empty()) continue;
    ++with_new_marks;
    Reference reference(named.story);
    const std::vector<std::uint8_t> prior_of_marks = outputs(learned_networks().marks, found.marks);
    const std::vector<std::vector<float>> expected = reference.update_features(prior_of_marks);
    const std::vector<std::uint8_t> near_inside = reference.near_inside();
    ASSERT_EQ(found.update.size(), expected.size());
    const auto skip = [&](int v) { return reference.is_between_new(v); };
    int skipped = 0;
    for (int v = 0; v < static_cast<int>(prior_of_marks.size()); ++v) {
      skipped += skip(v);
      if (skip(v)) continue;
      ASSERT_EQ(found.near_inside[v], near_inside[v]) << named.name << ' ' << v;
      const double p = 1 / (1 + std::exp(-double{found.update[0][v]})), q = 1 / (1 + std::exp(-double{expected[0][v]}));
      ASSERT_NEAR(p, q, 1.01 / 256) << named.name << ' ' << v;  // outputs may be rounded otherwise
    }
    EXPECT_LT(skipped, static_cast<int>(prior_of_marks.size() / 20)) << named.name;
    for (std::size_t f = 1; f < expected.size(); ++f)
      EXPECT_EQ(differing(found.update[f], expected[f], 0.01, skip), 0) << named.name << ", feature " << f;
  }
  EXPECT_GE(with_new_marks, 6);
}

/// Blocks of one voxel. Networks evaluated in double may be rounded otherwise.
TEST(Prior, IsTheOutputOfTheNetworksForTheRecordedFeatures) {
  const CpuFieldExecutor executor;
  int compared = 0;
  for (const Named& named : stories())
    for (const bool threshold : {false, true}) {
      if (threshold && !named.story.new_balls().empty()) continue;
      EvidenceSettings settings;
      settings.expected_dice_threshold = threshold;
      const auto prior = named.story.computed(executor, settings);
      const PriorFeatures& found = prior.features();
      if (found.constraints.size() != named.story.constraints().size()) continue;
      ++compared;
      const std::vector<std::uint8_t> voxels = named.story.voxels_of(prior);
      std::vector<std::uint8_t> expected = outputs(learned_networks().marks, found.marks);
      double most = 1;
      if (!found.update.empty()) {
        const Reference reference(named.story);
        const std::vector<std::uint8_t> same_side = outputs(learned_networks().update, found.update);
        for (std::size_t v = 0; v < expected.size(); ++v)
          if (!reference.is_between_new(static_cast<int>(v))) {
            ASSERT_NEAR(voxels[v], reference.remembered(static_cast<int>(v), same_side[v]), 1.6)
                << named.name << ' ' << v;
          }
        continue;
      }
      if (threshold) {  // odds are multiplied so that the best threshold is 0.5
        std::vector<int> cells;
        for (std::size_t v = 0; v < expected.size(); ++v)
          if (found.constraints[v] == Constraint::None || found.constraints[v] == Constraint::Inside)
            cells.push_back(found.constraints[v] == Constraint::Inside ? 255 : expected[v]);
        std::ranges::sort(cells, std::greater<>());
        double all = 0, taken = 0, right = 0, best = 0;
        for (const int p : cells) all += p / 255.0;
        for (const int p : cells) ++taken, right += p / 255.0, best = std::max(best, 2 * right / (taken + all));
        const double cut = std::clamp(best / 2, 0.2, 0.5), odds = (1 - cut) / cut;
        for (std::uint8_t& p : expected)
          p = static_cast<std::uint8_t>(std::lround(255 * p * odds / (p * odds + 255 - p)));
        most = 1 + odds;
      }
      for (std::size_t v = 0; v < expected.size(); ++v)
        ASSERT_NEAR(voxels[v], expected[v], most) << named.name << ' ' << v;
      EXPECT_GT(*std::ranges::max_element(voxels), 128) << named.name;
    }
  EXPECT_GE(compared, 8);
}

TEST(Prior, EverySettingHasAnEffect) {
  const CpuFieldExecutor executor;
  const Story story(ellipsoid(32, 1, {10, 7, 8}, 25).image, {inside({0, 0, 0}, 6)}, {outside({12, 0, 0}, 2)});
  const auto usual_prior = story.computed(executor);
  const std::vector<std::uint8_t> usual = story.voxels_of(usual_prior);
  const std::vector<float> zeros(usual_prior.features().constraints.size());
  for (int feature = 0; feature < 3; ++feature) EXPECT_NE(usual_prior.features().marks[feature], zeros);
  int feature = 0;
  for (bool EvidenceSettings::*const use :
       {&EvidenceSettings::use_appearance, &EvidenceSettings::use_geodesic, &EvidenceSettings::use_random_walk}) {
    EvidenceSettings settings;
    settings.*use = false;
    const auto prior = story.computed(executor, settings);
    EXPECT_GT(difference(usual, story.voxels_of(prior)).most, 0);
    EXPECT_EQ(prior.features().marks[feature], zeros) << feature;
    ++feature;
  }
  EvidenceSettings settings;
  settings.memory = false;
  const auto forgets = story.computed(executor, settings);
  EXPECT_TRUE(forgets.features().update.empty());
  EXPECT_EQ(forgets.features().marks, usual_prior.features().marks);
  EXPECT_GT(difference(usual, story.voxels_of(forgets)).most, 0);
  settings.expected_dice_threshold = false;
  EXPECT_GT(difference(story.voxels_of(forgets), story.voxels_of(story.computed(executor, settings))).most, 0);
}

TEST(Prior, OpensTheSidesOfTheBoxWhereTheObjectContinues) {
  const Scene bar = ellipsoid(40, 1, {400, 8, 8}, 5);  // it extends beyond the box
  const CpuFieldExecutor executor;
  const VoxelBox box{{8, 4, 4}, {24, 32, 32}};
  const Story story(box, bar.image, inside({0, 0, 0}, 6));
  const auto prior = story.computed(executor);
  std::vector<std::uint8_t> open(box.voxel_count(), 7);
  prior.mark_open(story.constraints().data(), open.data());
  const PriorFeatures& found = prior.features();
  ASSERT_EQ(found.constraints.size(), open.size());
  int in_bar = 0, missed = 0, beside = 0;
  each_index({box.size}, [&](int i, int j, int k, int v) {
    const bool expected = story.constraints()[v] == Constraint::FarBorder &&
                          found.constraints[v] == Constraint::FarBorder &&
                          found.marks[0][v] > EvidenceSettings().open_side;
    ASSERT_EQ(open[v], expected) << v;
    const bool end = i == 0 || i == 23, within = std::hypot(j - 15.5, k - 15.5) < 6;
    in_bar += end && within && open[v];
    missed += end && within && !open[v];
    beside += std::hypot(j - 15.5, k - 15.5) > 11 && open[v];
  });
  EXPECT_GT(in_bar, 100);
  EXPECT_LT(missed, 20);
  EXPECT_LT(beside, 20);
}

TEST(Prior, AnyOrderOfJobsGivesTheSameBits) {
  const Scene scene = ellipsoid(36, 1, {12, 10, 9}, 25);
  const Story story(scene.image, {inside({0, 0, 0}, 8)}, {outside({15, 0, 0}, 3), inside({9, 3, 1}, 2)});
  const CpuFieldExecutor in_turn;
  const auto prior = story.computed(in_turn);
  for (const JobOrder& order : job_orders()) {
    const CpuFieldExecutor executor(order.run);
    const auto other = story.computed(executor);
    EXPECT_EQ(story.voxels_of(other), story.voxels_of(prior)) << order.name;
    EXPECT_EQ(other.features().marks, prior.features().marks) << order.name;
    EXPECT_EQ(other.features().update, prior.features().update) << order.name;
  }
}

TEST(Prior, IsReproducibleForAnyNumberOfUpdates) {
  const Counting executor;
  const Scene scene = ellipsoid(36, 1, {12, 10, 9}, 25);
  const Story one(scene.image, {inside({0, 0, 0}, 8)}, {outside({15, 0, 0}, 3)}),
      other(scene.image, {inside({0, 0, 0}, 8)}, {inside({9, 3, 1}, 2), boundary({0, 10, 0}, 2.5, {0, 1, 0})});
  ParallelPrior<Counting> prior = one.computed(executor);
  prior.record_features(false);
  one.compute(prior);  // the random walker starts from its last solution
  const std::vector<std::uint8_t> first = one.voxels_of(prior);
  EXPECT_LT(difference(first, one.voxels_of(one.computed(executor))).mean, 0.1);
  const std::size_t bytes = prior.bytes();
  executor.launches = executor.waits = executor.uploads = 0;
  one.compute(prior);
  EXPECT_EQ(prior.bytes(), bytes);  // no further allocation
  RecordProperty("launches", executor.launches);
  RecordProperty("waits", executor.waits);
  EXPECT_LT(executor.launches, 100);
  EXPECT_LT(executor.waits, 20);
  EXPECT_LT(difference(first, one.voxels_of(prior)).most, 6);
  other.compute(prior);
  EXPECT_GT(difference(first, one.voxels_of(prior)).most, 20);
  EXPECT_LT(difference(other.voxels_of(other.computed(executor)), other.voxels_of(prior)).mean, 0.1);
}

}  // namespace
}  // namespace simplexseg
