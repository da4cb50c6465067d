// SPDX-License-Identifier: Apache-2.0
#include "field/parallel/cpu_executor.h"
#include "field/parallel/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "field/box_image.h"
#include "field/field_object.h"
#include "field/field_voxel.h"
#include "references.h"

namespace simplexseg {
namespace {

/// Refines a field on the executor of the CPU. `previous`: previous field, or empty.
void refine(std::vector<float>& field, const FieldObject& object, const std::vector<Constraint>& constraints,
            const std::vector<float>& image, const std::vector<std::uint8_t>& previous, const VoxelBox& box,
            const std::array<double, 3>& spacing_mm, const BandTerms& terms, const EvidenceSettings& settings,
            const RunJobs& run = run_serially()) {
  const CpuFieldExecutor executor(run);
  refine_in_narrow_band(executor, field.data(), object.voxels.data(), object.bounds, constraints.data(), image.data(),
                        previous.empty() ? nullptr : previous.data(), box, spacing_mm, terms, settings);
}

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
  std::vector<Constraint> constraints;

  /// `contrast`: contrast of the ball, in standard deviations of the noise.
  explicit Ball(double contrast)
      : image(kBox.voxel_count()), field(kBox.voxel_count()), constraints(kBox.voxel_count(), Constraint::None) {
    std::mt19937 random(7);
    std::normal_distribution<float> noise(0.5f, 0.05f);
    for (std::size_t v = 0; v < image.size(); ++v) {
      const double r = from_centre(v);
      image[v] = noise(random) + (r < kTrueRadius ? static_cast<float>(0.05 * contrast) : 0.0f);
      field[v] = static_cast<float>(1 / (1 + std::exp((r - kFieldsRadius) / 3)));
      if (r < 4) constraints[v] = Constraint::Inside;
    }
  }
  FieldObject object() const { return object_of_field(field, constraints, kBox); }
  FieldObject settled(const EvidenceSettings& settings = {}, double offset = 0) {
    return settled_by({offset, 0, {}}, settings);
  }
  /// `previous`: previous field, or empty.
  FieldObject settled_by(const BandTerms& terms, const EvidenceSettings& settings = {},
                         const std::vector<std::uint8_t>& previous = {}) {
    refine(field, object(), constraints, image, previous, kBox, kSpacing, terms, settings);
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

TEST(NarrowBand, TheSurfaceMovesToWhereAppearanceChanges) {
  Ball ball(8);
  EXPECT_DOUBLE_EQ(of_rim(ball.object()), 0);
  const FieldObject settled = ball.settled();
  EXPECT_GE(of_rim(settled), 0.95);
  EXPECT_NEAR(static_cast<double>(voxels_of(settled)), 4.0 / 3 * M_PI * std::pow(kTrueRadius, 3), 100);
}

TEST(NarrowBand, WithoutALayerTheFieldIsUnchanged) {
  EvidenceSettings none;
  none.band_half_width = 0;
  Ball left(8);
  const std::vector<float> previous = left.field;
  EXPECT_DOUBLE_EQ(of_rim(left.settled(none)), 0);
  EXPECT_EQ(left.field, previous);
}

TEST(NarrowBand, TheSurfaceStaysWithoutContrast) {
  Ball ball(0);
  const std::size_t previous = voxels_of(ball.object());
  EXPECT_NEAR(static_cast<double>(voxels_of(ball.settled())), static_cast<double>(previous),
              0.01 * static_cast<double>(previous));
}

/// Object that ends before the appearance changes. Outside marks in one direction resemble the object, so appearance is
/// no longer used in any direction.
TEST(NarrowBand, MarksOverrideAppearance) {
  Ball ball(8);
  for (std::size_t v = 0; v < ball.constraints.size(); ++v) {
    const double r = from_centre(v), x = static_cast<double>(v % 40) - 19.5;
    if (r >= kFieldsRadius && r < kTrueRadius && x > 5) {
      ball.constraints[v] = Constraint::Outside;
      ball.field[v] = 0;
    }
  }
  const FieldObject previous = ball.object(), settled = ball.settled();
  double other_side = 0, changed = 0;
  for (std::size_t v = 0; v < previous.voxels.size(); ++v) {
    if (v % 40 >= 20) continue;
    other_side += previous.voxels[v];
    changed += settled.voxels[v] != previous.voxels[v];
  }
  EXPECT_LT(changed, 0.02 * other_side);
}

/// Without contrast bumps of a voxel are smoothed; the rest of the surface and its curvature stay.
TEST(NarrowBand, TheSurfaceIsSmoothWithoutContrast) {
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
  none.fairing_scale = 0.01;
  const int left = off(rough.settled(none)), evened = off(ball.settled());
  EXPECT_GT(left, 150);
  EXPECT_LT(evened, 0.4 * left);
}

/// The offset moves the whole surface, here by 3 voxels per unit of log odds.
TEST(NarrowBand, TheOffsetMovesTheWholeSurface) {
  for (const double offset : {-0.4, 0.4}) {
    Ball ball(0);
    const double radius = std::cbrt(static_cast<double>(voxels_of(ball.settled({}, offset))) * 3 / (4 * M_PI));
    EXPECT_NEAR(radius, kFieldsRadius + 3 * offset, 0.35) << offset;
  }
}

/// Previous field, in which the ball is 1.5 voxels larger.
std::vector<std::uint8_t> larger_before() {
  std::vector<std::uint8_t> previous(kBox.voxel_count());
  for (std::size_t v = 0; v < previous.size(); ++v) previous[v] = from_centre(v) < kFieldsRadius + 1.5 ? 255 : 1;
  return previous;
}
double radius_of(const FieldObject& object) {
  return std::cbrt(static_cast<double>(voxels_of(object)) * 3 / (4 * M_PI));
}

/// The temporal term pulls the surface to the previous one, except around a mark that lies deep in a wrong part; it has
/// no effect without a previous field.
TEST(NarrowBand, TheTemporalTermHoldsTheSurface) {
  Ball temporal(0), free(0), forgotten(0);
  const double radius = radius_of(free.settled_by({0, 0.6, {}}));
  EXPECT_NEAR(radius, kFieldsRadius, 0.2);
  EXPECT_GT(radius_of(temporal.settled_by({0, 0.6, {}}, {}, larger_before())), radius + 0.5);
  const SurfaceShift deep{{19.5f, 19.5f, 19.5f}, 0, 20};
  EXPECT_NEAR(radius_of(forgotten.settled_by({0, 0.6, {deep}}, {}, larger_before())), radius, 0.2);
}

/// A mark that moves the surface outwards or inwards acts beside it, not on the other side of the ball.
TEST(NarrowBand, FreshMarksMoveTheSurfaceBesideThem) {
  const auto gained = [](float outward_voxels) {
    std::vector<std::uint8_t> same(kBox.voxel_count());
    for (std::size_t v = 0; v < same.size(); ++v) same[v] = from_centre(v) < kFieldsRadius ? 255 : 1;
    const SurfaceShift move{{19.5f + 11, 19.5f, 19.5f}, outward_voxels, 0};
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

TEST(NarrowBand, MarkedVoxelsStay) {
  Ball ball(8);
  std::vector<std::size_t> marked;
  for (std::size_t v = 0; v < ball.constraints.size(); ++v) {
    const double x = static_cast<double>(v % 40) - 19.5;
    if (std::fabs(from_centre(v) - 9.6) > 0.5 || x < 8) continue;
    ball.constraints[v] = Constraint::Outside;
    ball.field[v] = 0;
    marked.push_back(v);
  }
  ASSERT_GT(marked.size(), 10u);
  ball.settled();
  for (const std::size_t v : marked) EXPECT_FLOAT_EQ(ball.field[v], 0);
}

/// On one side the same appearance continues beyond the object; there, and only there, appearance is not used.
TEST(NarrowBand, AppearanceThatContradictsTheFieldIsNotUsed) {
  Ball ball(8);
  const auto x_of = [](std::size_t v) { return static_cast<double>(v % 40) - 19.5; };
  for (std::size_t v = 0; v < ball.image.size(); ++v) {
    const double r = from_centre(v);
    if (x_of(v) > 0 && r >= kTrueRadius && r < kTrueRadius + 1) ball.image[v] += 0.4f;
  }
  const FieldObject previous = ball.object(), settled = ball.settled();
  double changed = 0, all = 0, moved = 0, rim = 0;
  for (std::size_t v = 0; v < previous.voxels.size(); ++v) {
    const double r = from_centre(v);
    if (x_of(v) > 7 && r < kTrueRadius + 3) {
      all += 1;
      changed += settled.voxels[v] != previous.voxels[v];
    }
    if (x_of(v) < -7 && r >= kFieldsRadius && r < kTrueRadius) {
      rim += 1;
      moved += settled.voxels[v];
    }
  }
  EXPECT_LT(changed / all, 0.05);
  EXPECT_GT(moved / rim, 0.9);
}

TEST(NarrowBand, BeyondTheLayerTheFieldStays) {
  Ball ball(8);
  const std::vector<float> previous = ball.field;
  ball.settled();
  double near = 0;
  for (std::size_t v = 0; v < previous.size(); ++v) {
    const double to_surface = std::fabs(from_centre(v) - kFieldsRadius);
    if (to_surface > EvidenceSettings{}.band_half_width + 1) {
      ASSERT_EQ(ball.field[v], previous[v]) << from_centre(v);
    }
    if (to_surface < 1) near += std::fabs(ball.field[v] - previous[v]);
  }
  EXPECT_GT(near, 10);
}

/// Voxels four times as thick as wide: the layer has the same thickness in mm.
TEST(NarrowBand, TheLayerIsAsThickInEveryDirection) {
  const VoxelBox box{{0, 0, 0}, {40, 40, 10}};
  const std::array<double, 3> spacing{1, 1, 4};
  const Ball fine(8);
  std::vector<float> image(box.voxel_count()), field(box.voxel_count());
  const std::vector<Constraint> constraints(box.voxel_count(), Constraint::None);
  std::vector<Constraint> seeded = constraints;
  const auto middle_of = [&](std::size_t v) { return v % 1600 + v / 1600 * 4 * 1600 + 2 * 1600; };
  for (std::size_t v = 0; v < image.size(); ++v) {
    image[v] = fine.image[middle_of(v)];
    field[v] = fine.field[middle_of(v)];
    if (fine.constraints[middle_of(v)] == Constraint::Inside) seeded[v] = Constraint::Inside;
  }
  const std::vector<float> previous = field;
  refine(field, object_of_field(field, seeded, box), seeded, image, {}, box, spacing, {}, {});
  for (const int k : {2, 7}) {  // the next slices above and below the object, more than two voxels' width from it
    EXPECT_EQ(field[box.offset(19, 19, k)], previous[box.offset(19, 19, k)]) << k;
  }
  const FieldObject settled = object_of_field(field, seeded, box);
  double in = 0, all = 0;
  for (std::size_t v = 0; v < image.size(); ++v) {
    const double r = from_centre(middle_of(v));
    if (r < kFieldsRadius || r >= kTrueRadius) continue;
    all += 1;
    in += settled.voxels[v];
  }
  EXPECT_GE(in / all, 0.8);
}

/// Field refined with the formulas of surface_voxel.h on all voxels of the box, distances by distance_map().
std::vector<float> reference(const std::vector<float>& field, const std::vector<std::uint8_t>& object,
                             const std::vector<Constraint>& constraints, const std::vector<float>& image,
                             const std::vector<std::uint8_t>& previous, const VoxelBox& box,
                             const std::array<double, 3>& spacing_mm, const BandTerms& terms,
                             const EvidenceSettings& settings) {
  using namespace surface;
  using List = std::vector<float>;
  const BoxGrid grid{box.size};
  const int n = grid.count();
  const auto voxel_mm = static_cast<float>(std::min({spacing_mm[0], spacing_mm[1], spacing_mm[2]}));
  const auto band_mm = static_cast<float>(settings.band_half_width) * voxel_mm;
  const float near_mm = band_mm + 2.5f * static_cast<float>(settings.band_window) * voxel_mm;
  const auto list = [&](const auto& value) {
    List values(n);
    for (int v = 0; v < n; ++v) values[v] = static_cast<float>(value(v));
    return values;
  };
  const auto smoothed = [&](List values, double voxels) {
    smooth_by_least_spacing(values, grid, spacing_mm, voxels, run_serially());
    return values;
  };
  const auto to_surface = [&](const std::vector<std::uint8_t>& set) {
    std::vector<std::uint8_t> rest(n);
    for (int v = 0; v < n; ++v) rest[v] = !set[v];
    const Eigen::Matrix3d mm = Eigen::Vector3d(spacing_mm[0], spacing_mm[1], spacing_mm[2]).asDiagonal();
    const List to_set = distance_map(set, box, mm), to_rest = distance_map(rest, box, mm);
    return list([&](int v) { return (set[v] ? to_rest[v] : to_set[v]) - voxel_mm / 2; });
  };
  const List distance = to_surface(object);
  std::vector<float> steps;
  each_index(grid, [&](int i, int, int, int v) {
    if (i + 1 < grid.size[0] && object[v] && object[v + 1]) steps.push_back(std::fabs(image[v + 1] - image[v]));
  });
  const float noise = noise_of_median(quantile(steps, 0.5));
  const auto sums = [&](const std::vector<std::uint8_t>& only) {
    std::array<List, 3> sums;
    for (int power = 0; power < 3; ++power)
      sums[power] =
          smoothed(list([&](int v) { return distance[v] < near_mm && only[v] ? std::pow(image[v], power) : 0; }),
                   settings.band_window);
    return sums;
  };
  const std::array<List, 3> all = sums(std::vector<std::uint8_t>(n, 1));
  const List smoothed_once = smoothed(field, settings.fairing_scale),
             smoothed_twice = smoothed(smoothed_once, settings.fairing_scale);
  TemporalTerm temporal = temporal_term(terms, {{0, 0, 0}, box.size}, spacing_mm, settings);
  std::vector<std::uint8_t> had(n), is = object;
  for (int v = 0; v < n && !previous.empty(); ++v) had[v] = previous[v] > 127;
  const List previous_distance = previous.empty() ? List() : to_surface(had);
  if (!previous.empty())
    temporal.shifts = terms.shifts.data(), temporal.object = had.data(), temporal.distance = previous_distance.data();
  List trusted(n), odds_now(n), result = field;
  for (int pass = 0; pass < 2; ++pass) {
    const std::array<List, 3> in = sums(is);
    const List log_odds = smoothed(list([&](int v) {
                                     return appearance_log_odds(image[v], in[0][v], in[1][v], in[2][v], all[0][v],
                                                                all[1][v], all[2][v], noise * noise);
                                   }),
                                   0.7);
    const auto agrees = [&](int v) { return (log_odds[v] > 0) == (object[v] != 0); };
    const auto part = [&](bool inner, bool agreed) {
      return smoothed(
          list([&](int v) { return distance[v] < band_mm && (object[v] != 0) == inner && (!agreed || agrees(v)); }), 4);
    };
    if (pass == 0) {
      const std::array<List, 4> parts{part(true, false), part(true, true), part(false, false), part(false, true)};
      float agreement = 1;
      for (const Constraint kind : {Constraint::Inside, Constraint::Outside}) {
        float marks = 60, agreed = 60;
        for (int v = 0; v < n; ++v) {
          if (constraints[v] != kind || distance[v] >= band_mm) continue;
          ++marks;
          agreed += (log_odds[v] > 0) == (kind == Constraint::Inside);
        }
        agreement = std::min(agreement, agreed / marks);
      }
      const float of_marks = std::clamp((agreement - 0.8f) / 0.1f, 0.0f, 1.0f);
      trusted =
          list([&](int v) { return local_weight(parts[0][v], parts[1][v], parts[2][v], parts[3][v]) * of_marks; });
    }
    for (int v = 0; v < n; ++v) {
      if (constraints[v] != Constraint::None || distance[v] >= band_mm) continue;
      const float from_marks = static_cast<float>(terms.offset_log_odds) + temporal(v, trusted[v]);
      odds_now[v] =
          band_log_odds(field[v], 2 * smoothed_once[v] - smoothed_twice[v], log_odds[v], trusted[v], from_marks);
      is[v] = odds_now[v] > 0;
      result[v] = probability_of(odds_now[v]);
    }
  }
  return result;
}

/// Ball in noise, and a field whose surface is displaced, with and without a previous field and new marks.
TEST(NarrowBand, EqualsTheFormulasOnTheWholeBox) {
  int moved = 0;
  for (const std::array<double, 3>& spacing : {std::array{1.0, 1.0, 1.0}, std::array{0.8, 0.8, 3.0}})
    for (const double offset : {0.0, 0.6}) {
      const VoxelBox box{{2, 3, 4}, {44, 44, spacing[2] > 2 ? 16 : 44}};
      const BoxGrid grid{box.size};
      std::mt19937 random(9);
      std::normal_distribution<float> noise(0, 0.04f);
      std::vector<float> image(grid.count()), field(grid.count());
      std::vector<Constraint> constraints(grid.count(), Constraint::None);
      each_index(grid, [&](int i, int j, int k, int v) {
        const double x = (i - 21) * spacing[0], y = (j - 21) * spacing[1], z = (k - 0.5 * box.size[2]) * spacing[2],
                     r = std::sqrt(x * x + y * y + z * z);
        image[v] = (r < 12 ? 0.6f : 0.3f) + noise(random);
        field[v] = static_cast<float>(1 / (1 + std::exp(1.2 * (r - 10.6 + 0.8 * std::sin(x)))));
        const unsigned mark = random() % 200;
        if (mark < 2) constraints[v] = r < 9 || (r < 12 && mark == 1) ? Constraint::Inside : Constraint::Outside;
        if (mark == 2) constraints[v] = Constraint::NotFinite;
      });
      constraints[box.offset(21, 21, box.size[2] / 2)] = Constraint::Inside;
      const FieldObject object = object_of_field(field, constraints, box);
      ASSERT_GT(object.bounds.voxel_count(), 1000u);
      // Previous field with another surface, and two new marks: one at the surface, one deep.
      std::vector<std::uint8_t> previous;
      BandTerms terms{offset, 0, {}};
      if (offset != 0) {
        for (int v = 0; v < grid.count(); ++v) previous.push_back(to_8_bits(field[v > 1 ? v - 2 : v]));
        terms.temporal_weight = 0.7;
        for (const float x : {10.0f, -11.0f})
          terms.shifts.push_back({{static_cast<float>(21 * spacing[0]) + x, static_cast<float>(21 * spacing[1]),
                                   static_cast<float>(0.5 * box.size[2] * spacing[2])},
                                  x > 0 ? 1.5f : 0.0f,
                                  x > 0 ? 0.0f : 3.0f});
      }
      const std::vector<float> expected =
          reference(field, object.voxels, constraints, image, previous, box, spacing, terms, {});
      std::vector<float> refined = field;
      refine(refined, object, constraints, image, previous, box, spacing, terms, {});
      int other_side = 0;
      for (int v = 0; v < grid.count(); ++v) {
        EXPECT_NEAR(refined[v], expected[v], 0.02) << v;
        other_side += (refined[v] > 0.5f) != (expected[v] > 0.5f);
        moved += std::fabs(expected[v] - field[v]) > 0.2;
      }
      EXPECT_LE(other_side, 2);
      for (const JobOrder& order : job_orders()) {
        std::vector<float> again = field;
        refine(again, object, constraints, image, previous, box, spacing, terms, {}, order.run);
        EXPECT_EQ(again, refined) << order.name;
      }
    }
  EXPECT_GT(moved, 500);
}

/// 2 sum(P in the object) / (voxels of the object + sum(P)).
TEST(NarrowBand, ExpectedDiceIsThatOfIndependentVoxels) {
  const Ball ball(8);
  const FieldObject object = ball.object();
  const int n = static_cast<int>(kBox.voxel_count());
  double in = 0, all = 0;
  for (int v = 0; v < n; ++v) all += ball.field[v], in += object.voxels[v] ? ball.field[v] : 0;
  const CpuFieldExecutor executor;
  const auto dice = [&](const std::vector<std::uint8_t>& voxels) {
    return end_expected_dice(executor, begin_expected_dice(executor, n, ball.field.data(), voxels.data()));
  };
  EXPECT_NEAR(dice(object.voxels), 2 * in / (static_cast<double>(object.count) + all), 1e-6);
  EXPECT_EQ(dice(std::vector<std::uint8_t>(n)), 0);
}

}  // namespace
}  // namespace simplexseg
