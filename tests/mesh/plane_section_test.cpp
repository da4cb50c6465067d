// SPDX-License-Identifier: Apache-2.0
#include "mesh/plane_section.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "mesh/iso_surface.h"

namespace simplexseg {
namespace {

double area_of(const std::vector<Polygon>& polygons) {
  double area = 0;
  for (const Polygon& polygon : polygons) area += 0.5 * doubled_area(polygon);
  return area;
}

SimplexMesh torus() {
  const std::array<int, 3> size{40, 40, 16};
  std::vector<float> values;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i)
        values.push_back(static_cast<float>(4 - std::hypot(std::hypot(i - 20.0, j - 20.0) - 12, k - 8.0)));
  return dual_of(iso_surface(values, size, 0, Eigen::Affine3d::Identity()));
}

TEST(PlaneSections, OfASphereAreDiscsForAnyGeometry) {
  const SimplexMesh sphere = make_sphere({3, -4, 5}, 10, 4);
  for (const double side : {1.0, -1.0}) {
    Eigen::Affine3d world = Eigen::Affine3d::Identity();
    world.linear() << 0, 0, 2 * side, 0.5, 0, 0, 0, 0.5, 0;  // k is +-x in steps of 2 mm, pixels of 0.5 mm
    world.translation() << 3 - 14 * side, -20, -10;
    const auto sections = plane_sections(sphere, world.inverse(), 14);
    ASSERT_EQ(sections.size(), 14u);
    for (int k = 0; k < 14; ++k) {
      const double x = 2 * k - 14, radius2 = 100 - x * x;
      if (std::abs(x) >= 10) {
        EXPECT_TRUE(std::abs(x) == 10 || sections[k].empty()) << k;
        continue;
      }
      ASSERT_EQ(sections[k].size(), 1u) << k;
      const double mm2 = 0.25 * area_of(sections[k]);
      EXPECT_NEAR(mm2, std::numbers::pi * radius2, 3) << "counter-clockwise, " << k << ", " << side;
      for (const Eigen::Vector2d& p : sections[k][0]) {
        const Eigen::Vector3d mm = world * Eigen::Vector3d(p[0], p[1], k);
        EXPECT_NEAR((mm - Eigen::Vector3d(3, -4, 5)).norm(), 10, 0.06);
      }
    }
  }
}

TEST(PlaneSections, HolesRunClockwiseAndAreJoinedByKeyholes) {
  const auto sections = plane_sections(torus(), Eigen::Affine3d::Identity(), 16);
  const std::vector<Polygon>& ring = sections[8];
  ASSERT_EQ(ring.size(), 2u);
  const double sum = 0.5 * (std::abs(doubled_area(ring[0])) + std::abs(doubled_area(ring[1])));
  const double area = std::numbers::pi * (16 * 16 - 8 * 8);
  EXPECT_NEAR(area_of(ring), area, 0.01 * area);
  EXPECT_NEAR(sum, std::numbers::pi * (16 * 16 + 8 * 8), 10);
  const std::vector<Polygon> cut = with_keyholes(ring);
  ASSERT_EQ(cut.size(), 1u);
  EXPECT_NEAR(area_of(cut), area_of(ring), 1e-9);
  EXPECT_EQ(cut[0].size(), ring[0].size() + ring[1].size() + 2);
}

TEST(PlaneSections, APlaneMayPassThroughVertices) {
  // A box whose lower face lies in the plane 2 and whose upper one lies in the plane 5.
  SimplexMesh box;
  for (int c = 0; c < 8; ++c) box.positions.emplace_back(c & 1 ? 4.0f : 1.0f, c & 2 ? 4.0f : 1.0f, c & 4 ? 5.0f : 2.0f);
  box.neighbours = {{1, 4, 2}, {0, 3, 5}, {0, 6, 3}, {1, 2, 7}, {0, 5, 6}, {1, 7, 4}, {2, 4, 7}, {3, 6, 5}};
  for (auto& n : box.neighbours) std::swap(n[0], n[1]);
  const auto sections = plane_sections(box, Eigen::Affine3d::Identity(), 8);
  for (int k = 0; k < 8; ++k) EXPECT_NEAR(std::abs(area_of(sections[k])), k > 2 && k <= 5 ? 9 : 0, 1e-9) << k;
}

}  // namespace
}  // namespace simplexseg
