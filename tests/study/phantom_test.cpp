// SPDX-License-Identifier: Apache-2.0
#include "study/phantom.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.h"
#include "image/mask.h"

namespace simplexseg {
namespace {

/// Share of the volume that is brighter than the background; partial voxels count by their share.
double bright_share(const Phantom& phantom, const PhantomSettings& settings) {
  double sum = 0;
  const VolumeGeometry& g = phantom.image.geometry();
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        sum += (phantom.image.value(i, j, k) - settings.background) / settings.contrast;
  return sum / double(g.voxel_count());
}

double label_share(const Phantom& phantom) {
  double count = 0;
  for (auto v : mask_of(phantom.labels, std::nullopt).voxels) count += v;
  return count / double(phantom.labels.geometry().voxel_count());
}

TEST(Phantom, ShapesHaveTheirVolumes) {
  const double pi = std::numbers::pi;
  const std::pair<const char*, double> truths[] = {{"sphere", 4.0 / 3 * pi * std::pow(0.3, 3)},
                                                   {"ellipsoid", 4.0 / 3 * pi * 0.36 * 0.25 * 0.18},
                                                   {"cube", 0.125},
                                                   {"torus", 2 * pi * pi * 0.25 * 0.1 * 0.1},
                                                   {"two-spheres", 8.0 / 3 * pi * std::pow(0.16, 3)}};
  PhantomSettings settings;
  settings.type = VoxelType::Float32;
  for (const auto& [kind, volume] : truths) {
    const Phantom phantom = make_phantom(kind, settings);
    EXPECT_NEAR(bright_share(phantom, settings) / volume, 1, 0.002) << kind;
    EXPECT_NEAR(label_share(phantom) / volume, 1, 0.02) << kind;
  }
}

TEST(Phantom, EveryKindHasATruthThatItsImageShows) {
  for (const PhantomKind& kind : phantom_kinds()) {
    PhantomSettings settings;
    settings.size = 40;
    const Phantom phantom = make_phantom(kind.name, settings);
    EXPECT_TRUE(phantom.image.geometry().same_grid(phantom.labels.geometry()));
    EXPECT_LT(phantom.image.geometry().centre_mm().norm(), 1e-9);
    EXPECT_EQ(phantom.image.type(), VoxelType::Int16);
    EXPECT_EQ(phantom.labels.type(), VoxelType::UInt8);
    EXPECT_GT(std::string(kind.doc).size(), 10u);
    const std::string name = kind.name;
    if (name == "flat" || name == "ramp") {
      EXPECT_EQ(phantom.labels.range().max, 0) << name;
      EXPECT_EQ(phantom.image.range().min, 50) << name;
      EXPECT_EQ(phantom.image.range().max, name == "flat" ? 50 : 150) << name;
      continue;
    }
    EXPECT_EQ(phantom.labels.range().max, name == "two-spheres" ? 2 : 1) << name;
    EXPECT_EQ(phantom.image.range().min, 50) << name;
    EXPECT_EQ(phantom.image.range().max, 150) << name;
    int between = 0, wrong = 0;
    for (int k = 0; k < 40; ++k)
      for (int j = 0; j < 40; ++j)
        for (int i = 0; i < 40; ++i) {
          const double value = phantom.image.value(i, j, k);
          between += value > 50 && value < 150;
          // A voxel whose centre is inside is at least half full; at corners at least 0.3.
          wrong += phantom.labels.value(i, j, k) != 0 ? value < 80 : value > 120;
          // Objects do not touch the border, which would cut off a mesh.
          if (i == 0 || j == 0 || k == 0 || i == 39 || j == 39 || k == 39) wrong += value != 50;
        }
    EXPECT_EQ(wrong, 0) << name;
    // The faces of the cube are between voxels at this size: only the cube has no partial voxels.
    if (name == "cube")
      EXPECT_EQ(between, 0);
    else
      EXPECT_GT(between, 100) << name;
  }
}

TEST(Phantom, TheTubeIsOneThinPieceBentInAllDirections) {
  PhantomSettings settings;
  const Phantom phantom = make_phantom("tube", settings);
  const Mask mask = mask_of(phantom.labels, 1);
  std::array<int, 3> low{64, 64, 64}, high{-1, -1, -1};
  std::vector<std::size_t> stack;
  std::vector<std::uint8_t> left = mask.voxels;
  std::size_t count = 0, reached = 0;
  for (std::size_t v = 0; v < left.size(); ++v) {
    if (!left[v]) continue;
    ++count;
    const std::array<int, 3> index{int(v % 64), int(v / 64 % 64), int(v / 4096)};
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], index[a]);
      high[a] = std::max(high[a], index[a]);
    }
    if (stack.empty()) stack.push_back(v);
  }
  left[stack.front()] = 0;
  while (!stack.empty()) {
    const std::size_t v = stack.back();
    stack.pop_back();
    ++reached;
    for (std::ptrdiff_t step : {-1, 1, -64, 64, -4096, 4096})
      if (left[v + step]) {
        left[v + step] = 0;
        stack.push_back(v + step);
      }
  }
  EXPECT_EQ(reached, count);
  for (int a = 0; a < 3; ++a) EXPECT_GT(high[a] - low[a], 20) << a;
  // A thin object fills a small share of its bounding box.
  EXPECT_LT(double(count), 0.12 * (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]));
}

TEST(Phantom, NoiseIsGaussianAndRepeatable) {
  PhantomSettings settings;
  settings.noise_sigma = 20;
  settings.type = VoxelType::Float64;
  const Phantom a = make_phantom("flat", settings), b = make_phantom("flat", settings);
  settings.seed = 2;
  const Phantom other = make_phantom("flat", settings);
  const auto va = std::as_const(a).image.voxels<double>(), vb = std::as_const(b).image.voxels<double>();
  const auto vo = std::as_const(other).image.voxels<double>();
  const double n = double(va.size());
  double mean = 0, variance = 0, fourth = 0, beside = 0, across = 0, beyond_two = 0;
  for (std::size_t v = 0; v < va.size(); ++v) {
    ASSERT_EQ(va[v], vb[v]);
    const double z = (va[v] - 50) / 20;
    mean += z / n;
    variance += z * z / n;
    fourth += z * z * z * z / n;
    beyond_two += (std::abs(z) > 2) / n;
    if (v > 0) beside += z * (va[v - 1] - 50) / 20 / n;
    across += z * (vo[v] - 50) / 20 / n;
  }
  // 262144 voxels: a standard error is 0.002.
  EXPECT_NEAR(mean, 0, 0.01);
  EXPECT_NEAR(variance, 1, 0.015);
  EXPECT_NEAR(fourth, 3, 0.1);
  EXPECT_NEAR(beyond_two, 0.0455, 0.002);
  EXPECT_NEAR(beside, 0, 0.01);
  EXPECT_NEAR(across, 0, 0.01);
}

TEST(Phantom, NoiseIsTheSameOnEveryMachine) {
  PhantomSettings settings;
  settings.size = 8;
  settings.noise_sigma = 100;
  const Phantom phantom = make_phantom("flat", settings);
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a; an independent program computes the same value
  for (std::int16_t v : std::as_const(phantom).image.voxels<std::int16_t>()) {
    hash = (hash ^ std::uint16_t(v)) * 1099511628211u;
  }
  EXPECT_EQ(hash, 13114003345065507055u);
}

TEST(Phantom, IntegerTypesSaturate) {
  PhantomSettings settings;
  settings.size = 8;
  settings.background = -20;
  settings.contrast = 1000;
  settings.type = VoxelType::UInt8;
  const Phantom phantom = make_phantom("cube", settings);
  EXPECT_EQ(phantom.image.value(0, 0, 0), 0);
  EXPECT_EQ(phantom.image.value(4, 4, 4), 255);
}

TEST(Phantom, SettingsOutOfRangeAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make_phantom("dodecahedron", {}), Error);
  EXPECT_THROW(make_phantom("sphere", {.size = 0}), Error);
  EXPECT_THROW(make_phantom("sphere", {.size = 100000}), Error);
  EXPECT_THROW(make_phantom("sphere", {.spacing_mm = 0}), Error);
  EXPECT_THROW(make_phantom("sphere", {.contrast = nan}), Error);
  EXPECT_THROW(make_phantom("sphere", {.background = nan}), Error);
  EXPECT_THROW(make_phantom("sphere", {.noise_sigma = -1}), Error);
}

TEST(ImageOfLabel, KeepsTheLabelsGridAndTheWantedType) {
  VolumeGeometry g;
  g.size = {5, 4, 3};
  g.spacing_mm = {0.5, 2, 3};
  g.origin_mm = {7, 8, 9};
  g.direction.col(0) *= -1;
  Volume labels(g, VoxelType::Int32);
  labels.voxels<std::int32_t>()[labels.offset(1, 2, 1)] = 3;
  labels.voxels<std::int32_t>()[labels.offset(2, 2, 1)] = 4;
  PhantomSettings settings{.size = 99, .contrast = -30, .background = 10, .type = VoxelType::Float32};
  const Volume one = image_of_label(labels, 3, settings), all = image_of_label(labels, std::nullopt, settings);
  EXPECT_TRUE(one.geometry().same_grid(g, 1e-12));
  EXPECT_EQ(one.type(), VoxelType::Float32);
  EXPECT_EQ(one.value(1, 2, 1), -20);
  EXPECT_EQ(one.value(2, 2, 1), 10);
  EXPECT_EQ(all.value(2, 2, 1), -20);
  EXPECT_EQ(all.value(0, 0, 0), 10);
  settings.noise_sigma = 5;
  EXPECT_NE(image_of_label(labels, 3, settings).value(0, 0, 0), 10);
}

}  // namespace
}  // namespace simplexseg
