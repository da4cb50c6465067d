// SPDX-License-Identifier: Apache-2.0
#include "io/picture/surface_picture.h"

#include <gtest/gtest.h>

#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

struct DrawnSurfaces {
  Picture picture{80, 60, std::vector<std::uint8_t>(3 * 80 * 60, 255)};
  Colour at(int x, int y) const {
    const std::uint8_t* const p = &picture.rgb[3 * (std::size_t(y) * picture.width + x)];
    return {p[0], p[1], p[2]};
  }
  void draw(const Eigen::Vector3f& centre, float radius, const Colour& colour, const Eigen::Matrix3f& view) {
    const TriangleMesh surface = tessellate(make_sphere(centre.cast<double>(), radius, 3));
    draw_surface(picture, 20, 0, 60, surface, std::vector<Colour>(surface.positions.size(), colour),
                 {view, {0, 0, 0}, 30});
  }
};
constexpr Colour kWhite{255, 255, 255};

TEST(SurfacePicture, ShowsASphereOfItsSizeBrightAtItsMiddleAndNothingElse) {
  DrawnSurfaces drawn;
  drawn.draw({0, 0, 0}, 15, {200, 100, 0}, view_from_front());
  const Colour middle = drawn.at(50, 30), edge = drawn.at(50, 17);
  EXPECT_NEAR(middle.red, 200, 3);
  EXPECT_NEAR(middle.green, 100, 3);
  EXPECT_LT(edge.red, 150) << "darker where the surface is seen at an angle";
  EXPECT_EQ(drawn.at(50, 13), kWhite);
  EXPECT_EQ(drawn.at(33, 30), kWhite);
  EXPECT_NE(drawn.at(36, 30), kWhite);
  EXPECT_EQ(drawn.at(5, 30), kWhite) << "outside the square";
}

TEST(SurfacePicture, ShowsTheLeftOfThePatientOnTheRightAndTheHeadUp) {
  DrawnSurfaces front, left;
  front.draw({15, 0, 0}, 5, {255, 0, 0}, view_from_front());
  front.draw({0, 0, 15}, 5, {0, 0, 255}, view_from_front());
  EXPECT_GT(front.at(65, 30).red, 200);
  EXPECT_EQ(front.at(65, 30).blue, 0);
  EXPECT_GT(front.at(50, 15).blue, 200);
  left.draw({0, -15, 0}, 5, {255, 0, 0}, view_from_left());
  EXPECT_EQ(left.at(35, 30).blue, 0) << "anterior is on the left";
}

TEST(SurfacePicture, HidesWhatIsBehind) {
  for (const bool front_first : {true, false}) {
    DrawnSurfaces drawn;
    const auto draw_both = [&] {
      TriangleMesh both = tessellate(make_sphere({0, -15, 0}, 6, 2));  // in front
      std::vector<Colour> colours(both.positions.size(), Colour{255, 0, 0});
      TriangleMesh behind = tessellate(make_sphere({0, 15, 0}, 12, 2));
      if (!front_first) std::swap(both, behind), colours.assign(both.positions.size(), Colour{0, 0, 255});
      const auto offset = static_cast<int>(both.positions.size());
      both.positions.insert(both.positions.end(), behind.positions.begin(), behind.positions.end());
      colours.resize(both.positions.size(), front_first ? Colour{0, 0, 255} : Colour{255, 0, 0});
      for (const auto& [a, b, c] : behind.triangles) both.triangles.push_back({a + offset, b + offset, c + offset});
      draw_surface(drawn.picture, 20, 0, 60, both, colours, {view_from_front(), {0, 0, 0}, 30});
    };
    draw_both();
    EXPECT_EQ(drawn.at(50, 30).blue, 0);
    EXPECT_EQ(drawn.at(50, 20).red, 0) << "the larger sphere around the smaller one";
  }
}

}  // namespace
}  // namespace simplexseg
