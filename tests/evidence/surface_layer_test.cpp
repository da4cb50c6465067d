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

/// Ball in an image, with an uncertain field in which it is most of a voxel too small.
struct Ball {
  std::vector<float> image, field;
  std::vector<Constraint> known;

  /// `contrast`: contrast of the ball, in standard deviations of the noise.
  explicit Ball(double contrast)
      : image(kBox.voxel_count()), field(kBox.voxel_count()), known(kBox.voxel_count(), Constraint::None) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0.5f, 0.05f);
    for (std::size_t v = 0; v < image.size(); ++v) {
      const double r = from_centre(v);
      image[v] = noise(random) + (r < kTrueRadius ? static_cast<float>(0.05 * contrast) : 0.0f);
      field[v] = static_cast<float>(1 / (1 + std::exp((r - kFieldsRadius) / 3)));
      if (r < 4) known[v] = Constraint::Inside;
    }
  }
  FieldObject object() const { return object_of_field(field, known, kBox, run_in_turn()); }
  FieldObject settled(const EvidenceSettings& settings = {}, double offset = 0) {
    return settled_by({offset, 0, {}}, settings);
  }
  /// `before`: previous field, or empty.
  FieldObject settled_by(const BandTerms& terms, const EvidenceSettings& settings = {},
                         const std::vector<std::uint8_t>& before = {}) {
    refine_in_narrow_band(field, object(), known, image, before, kBox, kSpacing, terms, settings, run_in_turn());
    return object();
  }
};

/// Share of the voxels between the field's surface and the true one that belong to the object.
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

TEST(SurfaceLayer, TheSurfaceMovesToWhereAppearanceChanges) {
  Ball ball(8);
  EXPECT_DOUBLE_EQ(of_rim(ball.object()), 0);
  const FieldObject settled = ball.settled();
  EXPECT_GE(of_rim(settled), 0.95);
  EXPECT_NEAR(static_cast<double>(voxels_of(settled)), 4.0 / 3 * M_PI * std::pow(kTrueRadius, 3), 100);
}

TEST(SurfaceLayer, WithoutALayerTheFieldIsUnchanged) {
  EvidenceSettings none;
  none.surface_layer = 0;
  Ball left(8);
  const std::vector<float> before = left.field;
  EXPECT_DOUBLE_EQ(of_rim(left.settled(none)), 0);
  EXPECT_EQ(left.field, before);
}

TEST(SurfaceLayer, TheSurfaceStaysWithoutContrast) {
  Ball ball(0);
  const std::size_t before = voxels_of(ball.object());
  EXPECT_NEAR(static_cast<double>(voxels_of(ball.settled())), static_cast<double>(before),
              0.01 * static_cast<double>(before));
}

/// Object that ends before the appearance changes. Outside marks in one direction resemble the object, so appearance is
/// no longer used in any direction.
TEST(SurfaceLayer, MarksOverrideAppearance) {
  Ball ball(8);
  for (std::size_t v = 0; v < ball.known.size(); ++v) {
    const double r = from_centre(v), x = static_cast<double>(v % 40) - 19.5;
    if (r >= kFieldsRadius && r < kTrueRadius && x > 5) {
      ball.known[v] = Constraint::Outside;
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

/// Without contrast bumps of a voxel are smoothed; the rest of the surface and its curvature stay.
TEST(SurfaceLayer, TheSurfaceIsSmoothWithoutContrast) {
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

/// The offset moves the whole surface, here by 3 voxels per unit of log odds.
TEST(SurfaceLayer, TheOffsetMovesTheWholeSurface) {
  for (const double offset : {-0.4, 0.4}) {
    Ball ball(0);
    const double radius = std::cbrt(static_cast<double>(voxels_of(ball.settled({}, offset))) * 3 / (4 * M_PI));
    EXPECT_NEAR(radius, kFieldsRadius + 3 * offset, 0.35) << offset;
  }
}

/// Previous field, in which the ball is 1.5 voxels larger.
std::vector<std::uint8_t> larger_before() {
  std::vector<std::uint8_t> before(kBox.voxel_count());
  for (std::size_t v = 0; v < before.size(); ++v) before[v] = from_centre(v) < kFieldsRadius + 1.5 ? 255 : 1;
  return before;
}
double radius_of(const FieldObject& object) {
  return std::cbrt(static_cast<double>(voxels_of(object)) * 3 / (4 * M_PI));
}

/// The temporal term pulls the surface to the previous one, except around a mark that lies deep in a wrong part; it has
/// no effect without a previous field.
TEST(SurfaceLayer, TheTemporalTermHoldsTheSurface) {
  Ball held(0), free(0), forgotten(0);
  const double radius = radius_of(free.settled_by({0, 0.6, {}}));
  EXPECT_NEAR(radius, kFieldsRadius, 0.2);
  EXPECT_GT(radius_of(held.settled_by({0, 0.6, {}}, {}, larger_before())), radius + 0.5);
  const SurfaceMove deep{{19.5f, 19.5f, 19.5f}, 0, 20};
  EXPECT_NEAR(radius_of(forgotten.settled_by({0, 0.6, {deep}}, {}, larger_before())), radius, 0.2);
}

/// A mark that moves the surface outwards or inwards acts beside it, not on the other side of the ball.
TEST(SurfaceLayer, FreshMarksMoveTheSurfaceBesideThem) {
  const auto gained = [](float out_voxels) {
    std::vector<std::uint8_t> same(kBox.voxel_count());
    for (std::size_t v = 0; v < same.size(); ++v) same[v] = from_centre(v) < kFieldsRadius ? 255 : 1;
    const SurfaceMove move{{19.5f + 11, 19.5f, 19.5f}, out_voxels, 0};
    Ball plain(0), moved(0);
    const FieldObject was = plain.settled_by({0, 0.6, {}}, {}, same), is = moved.settled_by({0, 0.6, {move}}, {}, same);
    std::array<int, 2> count{};  // beside the mark, and on the other side
    for (std::size_t v = 0; v < same.size(); ++v) {
      const double x = static_cast<double>(v % 40) - 19.5;
      if (std::fabs(x) > 2) count[x < 0 ? 1 : 0] += static_cast<int>(is.voxels[v]) - static_cast<int>(was.voxels[v]);
    }
    return count;
  };
  const std::array<int, 2> out = gained(2), in = gained(-2);
  EXPECT_GT(out[0], 60);
  EXPECT_LT(in[0], -60);
  EXPECT_NEAR(out[1], 0, 5);
  EXPECT_NEAR(in[1], 0, 5);
}

TEST(SurfaceLayer, MarkedVoxelsStay) {
  Ball ball(8);
  std::vector<std::size_t> marked;
  for (std::size_t v = 0; v < ball.known.size(); ++v) {
    const double x = static_cast<double>(v % 40) - 19.5;
    if (std::fabs(from_centre(v) - 9.6) > 0.5 || x < 8) continue;
    ball.known[v] = Constraint::Outside;
    ball.field[v] = 0;
    marked.push_back(v);
  }
  ASSERT_GT(marked.size(), 10u);
  ball.settled();
  for (const std::size_t v : marked) EXPECT_FLOAT_EQ(ball.field[v], 0);
}

/// On one side the same appearance continues beyond the object; there, and only there, appearance is not used.
TEST(SurfaceLayer, AppearanceThatContradictsTheFieldIsNotUsed) {
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

/// Voxels four times as thick as wide: the layer has the same thickness in mm.
TEST(SurfaceLayer, TheLayerIsAsThickInEveryDirection) {
  const VoxelBox box{{0, 0, 0}, {40, 40, 10}};
  const std::array<double, 3> spacing{1, 1, 4};
  const Ball fine(8);
  std::vector<float> image(box.voxel_count()), field(box.voxel_count());
  const std::vector<Constraint> known(box.voxel_count(), Constraint::None);
  std::vector<Constraint> seeded = known;
  const auto middle_of = [&](std::size_t v) { return v % 1600 + v / 1600 * 4 * 1600 + 2 * 1600; };
  for (std::size_t v = 0; v < image.size(); ++v) {
    image[v] = fine.image[middle_of(v)];
    field[v] = fine.field[middle_of(v)];
    if (fine.known[middle_of(v)] == Constraint::Inside) seeded[v] = Constraint::Inside;
  }
  const std::vector<float> before = field;
  refine_in_narrow_band(field, object_of_field(field, seeded, box, run_in_turn()), seeded, image, {}, box, spacing, {},
                        {}, run_in_turn());
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
