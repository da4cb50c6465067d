// SPDX-License-Identifier: Apache-2.0
// Objects that the volume cuts: through one side, two, an edge, a corner; thin and thick slices.
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "field/open_sides.h"
#include "image/metrics.h"

namespace simplexseg {
namespace {

using Contains = std::function<bool(const Eigen::Vector3d&)>;

Contains ball(const Eigen::Vector3d& centre, const Eigen::Vector3d& radii) {
  return [=](const Eigen::Vector3d& p) { return (p - centre).cwiseQuotient(radii).norm() <= 1; };
}
/// Tube along the line from `from` to `to`, with flat ends.
Contains tube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
  return [=](const Eigen::Vector3d& p) {
    const Eigen::Vector3d along = (to - from).normalized();
    const double t = along.dot(p - from);
    return t >= 0 && t <= (to - from).norm() && (p - from - t * along).norm() <= radius;
  };
}

struct CutObject {
  std::string name;
  std::array<int, 3> size;
  double thick;       ///< slices, mm; voxels are 1 mm wide
  Contains contains;  ///< mm, voxel (0, 0, 0) at the origin
  Mark seed;
  BoxSides sides;     ///< that cut it
  double noise = 15;  ///< of a contrast of 100
};

BoxSides sides(std::array<bool, 3> first, std::array<bool, 3> last) { return {first, last}; }

std::vector<CutObject> cut_objects() {
  const double far = 1000;
  return {
      {"tube through two sides",
       {40, 40, 26},
       1,
       tube({19.5, 19.5, -9}, {19.5, 19.5, far}, 8),
       inside({19.5, 19.5, 13}, 5),
       sides({false, false, true}, {false, false, true})},
      {"tube through one side",
       {40, 40, 36},
       1,
       tube({19.5, 19.5, 12}, {19.5, 19.5, far}, 8),
       inside({19.5, 19.5, 24}, 5),
       sides({}, {false, false, true})},
      {"half a ball",
       {48, 48, 36},
       1,
       ball({23, 24, 0}, {14, 14, 14}),
       inside({23, 24, 6}, 5),
       sides({false, false, true}, {})},
      {"ball cut near its end",
       {48, 48, 40},
       1,
       ball({23, 24, 29}, {14, 14, 14}),
       inside({23, 24, 26}, 7),
       sides({}, {false, false, true})},
      {"ellipsoid cut by an edge",
       {48, 48, 48},
       1,
       ball({4, 43, 24}, {16, 16, 12}),
       inside({8, 40, 24}, 6),
       sides({true, false, false}, {false, true, false})},
      {"ball cut by a corner",
       {44, 44, 44},
       1,
       ball({3, 3, 40}, {16, 16, 16}),
       inside({8, 8, 36}, 6),
       sides({true, true, false}, {false, false, true})},
      {"tube through thick slices",
       {40, 40, 12},
       5,
       tube({19.5, 19.5, -9}, {19.5, 19.5, far}, 9),
       inside({19.5, 19.5, 30}, 6),
       sides({false, false, true}, {false, false, true})},
      {"half an ellipsoid of thick slices",
       {56, 56, 14},
       5,
       ball({28, 28, 0}, {15, 15, 36}),
       inside({28, 28, 10}, 8),
       sides({false, false, true}, {})},
      {"tube within thick slices",
       {48, 40, 14},
       5,
       tube({-9, 19.5, 32}, {far, 19.5, 32}, 10),
       inside({20, 19.5, 32}, 7),
       sides({true, false, false}, {true, false, false})},
      {"oblique tube",
       {44, 40, 44},
       1,
       tube({-20, 19.5, -24}, {26, 19.5, 28}, 8),
       inside({18, 19.5, 19}, 5),
       sides({true, false, true}, {})},
  };
}

Scene scene_of(const CutObject& object) {
  VolumeGeometry geometry;
  geometry.size = object.size;
  geometry.spacing_mm = {1, 1, object.thick};
  return scene_of(
      geometry, [&](const Eigen::Vector3d& p) { return object.contains(p) ? 150.0 : 50.0; }, object.noise);
}

double share_of_side(const Mask& truth, const Mask& found, int axis, bool last) {
  std::size_t v = 0, all = 0, right = 0;
  const auto& size = truth.geometry.size;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i, ++v) {
        const int at[3]{i, j, k};
        if (at[axis] != (last ? size[axis] - 1 : 0) || !truth.voxels[v]) continue;
        ++all;
        right += found.voxels[v] != 0;
      }
  return all == 0 ? 1 : static_cast<double>(right) / static_cast<double>(all);
}

TEST(CutObjects, AreFoundUpToTheSidesOfTheVolume) {
  for (const CutObject& object : cut_objects()) {
    SCOPED_TRACE(object.name);
    const Scene scene = scene_of(object);
    EvidenceField field(scene.image);
    field.update(std::vector{object.seed});
    EXPECT_EQ(field.report().open_sides, object.sides);
    const Mask found = field.object();
    EXPECT_GE(dice(scene.truth, found), 0.97);
    EvidenceSettings closed;
    closed.open_cut_sides = false;
    EvidenceField field_with_closed_sides(scene.image, run_serially(), closed);
    field_with_closed_sides.update(std::vector{object.seed});
    const double dice_with_closed_sides = dice(scene.truth, field_with_closed_sides.object());
    EXPECT_LT(dice_with_closed_sides, dice(scene.truth, found));
    RecordProperty(std::string("closed, open: ") + object.name,
                   std::to_string(dice_with_closed_sides) + ", " + std::to_string(dice(scene.truth, found)));
    for (int a = 0; a < 3; ++a)
      for (const bool last : {false, true}) EXPECT_GE(share_of_side(scene.truth, found, a, last), 0.9) << a << last;
    EXPECT_FALSE(field.report().leaks);
  }
}

/// Objects that end near a side, and a bright neighbour that reaches it: the sides stay closed.
TEST(CutObjects, SidesNearAnObjectThatEndsBeforeThemStayClosed) {
  const Contains whole = ball({23, 24, 18}, {14, 14, 14});
  for (const int gap : {2, 3, 5}) {
    const CutObject object{"", {48, 48, 33 + gap}, 1, whole, inside({23, 24, 18}, 8), {}};
    const Scene scene = scene_of(object);
    EvidenceField field(scene.image);
    field.update(std::vector{object.seed});
    EXPECT_FALSE(field.report().open_sides.any()) << gap;
    EXPECT_GE(dice(scene.truth, field.object()), 0.97) << gap;
  }
}

/// An update with another seed, after the marks that opened a side were removed, equals one of a new field.
TEST(CutObjects, SidesAreClosedAgainWithoutTheMarksThatOpenedThem) {
  const CutObject object = cut_objects()[1];
  const Scene scene = scene_of(object);
  const Mark elsewhere = inside({6, 6, 6}, 2);
  EvidenceField field(scene.image), fresh(scene.image);
  field.update(std::vector{object.seed});
  ASSERT_TRUE(field.report().open_sides.any());
  field.update(std::vector{elsewhere});
  fresh.update(std::vector{elsewhere});
  EXPECT_EQ(field.report().open_sides, fresh.report().open_sides);
  EXPECT_FALSE(fresh.report().open_sides.any());
}

TEST(CutObjects, CutSidesNeedContactResemblanceAndASurroundingThatDiffers) {
  VolumeGeometry geometry;
  geometry.size = {30, 30, 20};
  const VoxelBox box{{0, 0, 0}, geometry.size};
  const std::size_t n = box.voxel_count();
  const auto test = [&](int first_layer, float gap, float around) {
    std::vector<std::uint8_t> object(n);
    std::vector<float> image(n, 0.2f);
    for (int k = 0; k < 20; ++k)
      for (int j = 0; j < 30; ++j)
        for (int i = 0; i < 30; ++i) {
          const bool in = std::hypot(i - 15, j - 15) <= 6;
          const std::size_t v = box.offset(i, j, k);
          object[v] = in && k >= first_layer && k < 15;
          image[v] = k >= first_layer ? (in ? 0.8f : 0.2f) : in ? gap : around;
        }
    const std::vector<Constraint> known = constraint_mask(geometry, box, {}, {}, {});
    return cut_sides(geometry, box, object, image, known, {});
  };
  EXPECT_EQ(test(3, 0.8f, 0.2f), sides({false, false, true}, {}));
  EXPECT_FALSE(test(6, 0.8f, 0.2f).any()) << "too far from the side";
  EXPECT_FALSE(test(3, 0.25f, 0.2f).any()) << "the object ends before the side";
  EXPECT_FALSE(test(3, 0.8f, 0.8f).any()) << "nothing encloses it at the side";
}

}  // namespace
}  // namespace simplexseg
