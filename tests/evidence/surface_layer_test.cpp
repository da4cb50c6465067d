// SPDX-License-Identifier: Apache-2.0
#include "evidence/surface_layer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace simplexseg {
namespace {

constexpr VoxelBox kBox{{0, 0, 0}, {40, 40, 40}};
constexpr std::array<double, 3> kSpacing{1, 1, 1};
constexpr double kTrueRadius = 10, kFieldsRadius = 9.3;  // voxels

double from_centre(std::size_t v) {
  const double x = static_cast<double>(v % 40) - 19.5, y = static_cast<double>(v / 40 % 40) - 19.5;
  const double z = static_cast<double>(v / 1600) - 19.5;
  return std::sqrt(x * x + y * y + z * z);
}

/// A ball in an image; a field that says that it is most of a voxel smaller than it is, and is not sure of it.
struct Ball {
  std::vector<float> image, field;
  std::vector<Known> known;

  /// `contrast`: of the ball, in deviations of the noise.
  explicit Ball(double contrast)
      : image(kBox.voxel_count()), field(kBox.voxel_count()), known(kBox.voxel_count(), Known::Nothing) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0.5f, 0.05f);
    for (std::size_t v = 0; v < image.size(); ++v) {
      const double r = from_centre(v);
      image[v] = noise(random) + (r < kTrueRadius ? static_cast<float>(0.05 * contrast) : 0.0f);
      field[v] = static_cast<float>(1 / (1 + std::exp((r - kFieldsRadius) / 3)));
      if (r < 4) known[v] = Known::Inside;
    }
  }
  FieldObject object() const { return object_of_field(field, known, kBox, run_in_turn()); }
  FieldObject settled(const EvidenceSettings& settings = {}, double lean = 0) {
    settle_surface(field, object(), known, image, kBox, kSpacing, lean, settings, run_in_turn());
    return object();
  }
};

/// Share of the voxels between the field's surface and the true one that are the object.
double of_rim(const FieldObject& object) {
  double in = 0, all = 0;
  for (std::size_t v = 0; v < object.voxels.size(); ++v) {
    const double r = from_centre(v);
    if (r < kFieldsRadius || r >= kTrueRadius) continue;
    all += 1;
    in += object.voxels[v];
  }
  return in / all;
}

std::size_t voxels_of(const FieldObject& object) {
  return static_cast<std::size_t>(std::count(object.voxels.begin(), object.voxels.end(), 1));
}

TEST(SurfaceLayer, TheSurfaceMovesToWhereLooksChange) {
  Ball ball(8);
  EXPECT_DOUBLE_EQ(of_rim(ball.object()), 0);
  const FieldObject settled = ball.settled();
  EXPECT_GE(of_rim(settled), 0.95);
  EXPECT_NEAR(static_cast<double>(voxels_of(settled)), 4.0 / 3 * M_PI * std::pow(kTrueRadius, 3), 100);
}

TEST(SurfaceLayer, WithoutALayerTheFieldIsLeft) {
  EvidenceSettings none;
  none.surface_layer = 0;
  Ball left(8);
  const std::vector<float> before = left.field;
  EXPECT_DOUBLE_EQ(of_rim(left.settled(none)), 0);
  EXPECT_EQ(left.field, before);
}

TEST(SurfaceLayer, WhereLooksSayNothingTheSurfaceStays) {
  Ball ball(0);
  const std::size_t before = voxels_of(ball.object());
  EXPECT_NEAR(static_cast<double>(voxels_of(ball.settled())), static_cast<double>(before),
              0.01 * static_cast<double>(before));
}

/// An object that ends before looks change: marks of its outside look like it, in one direction; looks are no longer
/// believed in any.
TEST(SurfaceLayer, MarksThatContradictLooksAreBelieved) {
  Ball ball(8);
  for (std::size_t v = 0; v < ball.known.size(); ++v) {
    const double r = from_centre(v), x = static_cast<double>(v % 40) - 19.5;
    if (r >= kFieldsRadius && r < kTrueRadius && x > 5) {
      ball.known[v] = Known::Outside;
      ball.field[v] = 0;
    }
  }
  const FieldObject before = ball.object(), settled = ball.settled();
  double other_side = 0, changed = 0;
  for (std::size_t v = 0; v < before.voxels.size(); ++v) {
    if (v % 40 >= 20) continue;
    other_side += before.voxels[v];
    changed += settled.voxels[v] != before.voxels[v];
  }
  EXPECT_LT(changed, 0.02 * other_side);
}

/// Where looks say nothing bumps of a voxel go and the rest of the surface stays, a ball's bend as well.
TEST(SurfaceLayer, WhereLooksSayNothingTheSurfaceIsEven) {
  Ball ball(0);
  const FieldObject even = ball.object();
  std::mt19937 random(3);
  std::normal_distribution<float> bumps(0, 0.06f);
  for (float& p : ball.field) p = std::clamp(p + bumps(random), 0.0f, 1.0f);
  const auto off = [&](const FieldObject& object) {
    int count = 0;
    for (std::size_t v = 0; v < even.voxels.size(); ++v) count += object.voxels[v] != even.voxels[v];
    return count;
  };
  Ball rough = ball;
  EvidenceSettings none;
  none.surface_evenness = 0.01;
  const int left = off(rough.settled(none)), evened = off(ball.settled());
  EXPECT_GT(left, 150);
  EXPECT_LT(evened, 0.4 * left);
}

/// What clicks say of all of the surface moves all of it: by log odds of a field whose log odds change by 1 in 3
/// voxels.
TEST(SurfaceLayer, TheWholeSurfaceLeansTheWayItIsTold) {
  for (const double lean : {-0.4, 0.4}) {
    Ball ball(0);
    const double radius = std::cbrt(static_cast<double>(voxels_of(ball.settled({}, lean))) * 3 / (4 * M_PI));
    EXPECT_NEAR(radius, kFieldsRadius + 3 * lean, 0.35) << lean;
  }
}

TEST(SurfaceLayer, WhatIsMarkedStays) {
  Ball ball(8);
  std::vector<std::size_t> marked;
  for (std::size_t v = 0; v < ball.known.size(); ++v) {
    const double x = static_cast<double>(v % 40) - 19.5;
    if (std::fabs(from_centre(v) - 9.6) > 0.5 || x < 8) continue;
    ball.known[v] = Known::Outside;
    ball.field[v] = 0;
    marked.push_back(v);
  }
  ASSERT_GT(marked.size(), 10u);
  ball.settled();
  for (const std::size_t v : marked) EXPECT_FLOAT_EQ(ball.field[v], 0);
}

/// On one side looks go on beyond the object: they are not believed there, and still on the other.
TEST(SurfaceLayer, LooksThatContradictTheFieldAroundAVoxelAreNotBelieved) {
  Ball ball(8);
  const auto x_of = [](std::size_t v) { return static_cast<double>(v % 40) - 19.5; };
  for (std::size_t v = 0; v < ball.image.size(); ++v) {
    const double r = from_centre(v);
    if (x_of(v) > 0 && r >= kTrueRadius && r < kTrueRadius + 1) ball.image[v] += 0.4f;
  }
  const FieldObject before = ball.object(), settled = ball.settled();
  double changed = 0, all = 0, moved = 0, rim = 0;
  for (std::size_t v = 0; v < before.voxels.size(); ++v) {
    const double r = from_centre(v);
    if (x_of(v) > 7 && r < kTrueRadius + 3) {
      all += 1;
      changed += settled.voxels[v] != before.voxels[v];
    }
    if (x_of(v) < -7 && r >= kFieldsRadius && r < kTrueRadius) {
      rim += 1;
      moved += settled.voxels[v];
    }
  }
  EXPECT_LT(changed / all, 0.05);
  EXPECT_GT(moved / rim, 0.9);
}

TEST(SurfaceLayer, BeyondTheLayerTheFieldStays) {
  Ball ball(8);
  const std::vector<float> before = ball.field;
  ball.settled();
  double near = 0;
  for (std::size_t v = 0; v < before.size(); ++v) {
    const double to_surface = std::fabs(from_centre(v) - kFieldsRadius);
    if (to_surface > EvidenceSettings{}.surface_layer + 1) {
      ASSERT_EQ(ball.field[v], before[v]) << from_centre(v);
    }
    if (to_surface < 1) near += std::fabs(ball.field[v] - before[v]);
  }
  EXPECT_GT(near, 10);
}

/// Voxels that are four times as thick as wide: the same place in mm.
TEST(SurfaceLayer, TheLayerIsAsThickInEveryDirection) {
  const VoxelBox box{{0, 0, 0}, {40, 40, 10}};
  const std::array<double, 3> spacing{1, 1, 4};
  const Ball fine(8);
  std::vector<float> image(box.voxel_count()), field(box.voxel_count());
  const std::vector<Known> known(box.voxel_count(), Known::Nothing);
  std::vector<Known> seeded = known;
  const auto middle_of = [&](std::size_t v) { return v % 1600 + v / 1600 * 4 * 1600 + 2 * 1600; };
  for (std::size_t v = 0; v < image.size(); ++v) {
    image[v] = fine.image[middle_of(v)];
    field[v] = fine.field[middle_of(v)];
    if (fine.known[middle_of(v)] == Known::Inside) seeded[v] = Known::Inside;
  }
  const std::vector<float> before = field;
  settle_surface(field, object_of_field(field, seeded, box, run_in_turn()), seeded, image, box, spacing, 0, {},
                 run_in_turn());
  for (const int k : {2, 7}) {  // the next slices above and below the object, more than two voxels' width from it
    EXPECT_EQ(field[box.offset(19, 19, k)], before[box.offset(19, 19, k)]) << k;
  }
  const FieldObject settled = object_of_field(field, seeded, box, run_in_turn());
  double in = 0, all = 0;
  for (std::size_t v = 0; v < image.size(); ++v) {
    const double r = from_centre(middle_of(v));
    if (r < kFieldsRadius || r >= kTrueRadius) continue;
    all += 1;
    in += settled.voxels[v];
  }
  EXPECT_GE(in / all, 0.8);
}

}  // namespace
}  // namespace simplexseg
