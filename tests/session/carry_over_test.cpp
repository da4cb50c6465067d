// SPDX-License-Identifier: Apache-2.0
// Segmentations carried over to another study, and their comparison with the earlier one.
#include "session/carry_over.h"

#include <cmath>

#include "field/surface_prior.h"
#include "gpu/backend.h"
#include "image/equalise.h"
#include "mesh/mesh_geometry.h"
#include "session/follow_up.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

constexpr double kBallRadius = 12, kGrown = 14;
const Eigen::Vector3d kBallCentre(32, 30, 31), kMoved(5, -4, 3);

/// Bright ball in a dark image with noise; a brighter corner box if `with_box`.
Volume ball_at(const Eigen::Vector3d& centre, double radius, bool with_box = false) {
  Volume volume(VolumeGeometry{.size = {64, 64, 64}}, VoxelType::Int16);
  unsigned noise = 1;
  for (int k = 0; k < 64; ++k)
    for (int j = 0; j < 64; ++j)
      for (int i = 0; i < 64; ++i) {
        noise = noise * 1664525 + 1013904223;
        const double distance = (Eigen::Vector3d(i, j, k) - centre).norm();
        double value = 100 / (1 + std::exp(2 * (distance - radius))) + (noise >> 24) * 0.1;
        if (with_box && i > 52 && j > 52) value += 600;
        volume.voxels<std::int16_t>()[volume.offset(i, j, k)] = static_cast<std::int16_t>(value);
      }
  return volume;
}

class CarryOverTest : public ::testing::Test {
 protected:
  CarryOverTest() {
    scene_.simulation = default_simulation_parameters();
    MeshItem item;
    item.id = 7, item.name = "lesion", item.label = 4, item.colour = {10, 20, 30};
    item.seed = {kBallCentre, 5};
    item.mesh = make_sphere(kBallCentre, kBallRadius, 3);
    item.parameters = default_force_parameters();
    scene_.meshes.push_back(item);
  }
  CarriedScene carry(const CarrySettings& settings = {}) const {
    return carry_over(scene_, earlier_, next_, Transform(Eigen::Affine3d(Eigen::Translation3d(kMoved))), settings);
  }
  void add_point(MarkKind kind, const Eigen::Vector3d& at, const Eigen::Vector3d& outward = Eigen::Vector3d::Zero()) {
    UserPoint point{static_cast<ItemId>(100 + scene_.points.size()), 7, at, kind,
                    kind == MarkKind::Boundary ? 0.0 : 2.0};
    point.outward = outward;
    scene_.points.push_back(point);
  }

  Volume earlier_ = ball_at(kBallCentre, kBallRadius);
  Volume next_ = ball_at(kBallCentre + kMoved, kGrown, true);
  Scene scene_;
};

TEST_F(CarryOverTest, SurfacesStartFromTheirImageAndKeepTheirAttributes) {
  const CarriedScene carried = carry();
  ASSERT_EQ(carried.scene.meshes.size(), 1u);
  const MeshItem& item = carried.scene.meshes[0];
  EXPECT_EQ(item.id, 7u);
  EXPECT_EQ(item.name, "lesion");
  EXPECT_EQ(item.label, 4);
  EXPECT_EQ(item.colour, (Colour{10, 20, 30}));
  ASSERT_TRUE(item.start && item.start->mesh);
  for (int v = 0; v < item.mesh.vertex_count(); ++v)
    EXPECT_LT((item.mesh.positions[v] - scene_.meshes[0].mesh.positions[v] - kMoved.cast<float>()).norm(), 1e-4f);
  EXPECT_EQ(item.start->error_mm, CarrySettings().error_mm);
  EXPECT_FALSE(item.is_given());
  EXPECT_LT((item.seed.centre_mm - kBallCentre - kMoved).norm(), 3);
  EXPECT_NEAR(item.start->earlier.volume_ml, measure(scene_.meshes[0].mesh).volume_mm3 / 1000, 1e-9);
  EXPECT_NEAR(item.start->earlier.long_mm, 2 * kBallRadius, 1);
  EXPECT_LT((item.start->earlier.centroid_mm - kBallCentre).norm(), 0.1);
}

TEST_F(CarryOverTest, WithoutAnExpectedErrorTheCarriedSurfaceIsTheSegmentation) {
  scene_.meshes[0].intensity_range = {-1000, 1000};
  const CarriedScene carried = carry({.error_mm = 0});
  ASSERT_EQ(carried.scene.meshes.size(), 1u);
  const MeshItem& item = carried.scene.meshes[0];
  EXPECT_TRUE(item.is_given());
  for (int v = 0; v < item.mesh.vertex_count(); ++v)
    EXPECT_LT((item.mesh.positions[v] - scene_.meshes[0].mesh.positions[v] - kMoved.cast<float>()).norm(), 1e-4f);
  EXPECT_FALSE(item.intensity_range.is_limited());
  ASSERT_EQ(carried.dropped.size(), 1u);
  EXPECT_EQ(carried.dropped[0].what, "range of intensities");
}

TEST_F(CarryOverTest, SettlesAtTheGrownObjectAndReportsTheChange) {
  Session session(make_cpu_engine(2), nullptr, 2);
  session.open(carry().scene, next_);
  EXPECT_TRUE(session.advance_steps(3000, true).at_rest);
  const std::vector<FollowUpRow> rows = follow_up_rows(session.scene(), next_.geometry());
  ASSERT_EQ(rows.size(), 1u);
  const double before = std::pow(kBallRadius, 3), after = std::pow(kGrown, 3);
  EXPECT_NEAR(rows[0].now.volume_ml / rows[0].earlier.volume_ml, after / before, 0.08 * after / before);
  EXPECT_NEAR(rows[0].change_percent(), 100 * (after / before - 1), 12);
  EXPECT_LT(rows[0].shift_mm, 0.5) << "the centre moved as the transform states";
  EXPECT_NEAR(rows[0].unregistered_shift_mm, kMoved.norm(), 0.5);
  EXPECT_NEAR(rows[0].carried_ml, rows[0].earlier.volume_ml, 1e-3);
  EXPECT_NEAR(rows[0].dice, 2 * before / (before + after), 0.04);
  const std::string csv = follow_up_csv(rows);
  EXPECT_EQ(csv.substr(0, 24), "name,locked,earlier_ml,n");
  EXPECT_NE(csv.find("\nlesion,0,"), std::string::npos);
}

TEST_F(CarryOverTest, ALockedSegmentationStaysExactlyAsCarried) {
  scene_.meshes[0].locked = true;
  const CarriedScene carried = carry();
  const MeshItem& item = carried.scene.meshes[0];
  EXPECT_TRUE(item.locked && item.is_given());
  const SimplexMesh start = item.mesh;
  Session session(make_cpu_engine(2), nullptr, 2);
  session.open(carried.scene, next_);
  session.advance_steps(200, true);
  EXPECT_EQ(session.scene().meshes[0].mesh.positions, start.positions);
}

TEST_F(CarryOverTest, MarksAreDroppedWhereTheImagesDiffer) {
  add_point(MarkKind::Inside, kBallCentre);
  add_point(MarkKind::Outside, {53, 61, 30});  // in the box of the new image
  add_point(MarkKind::Outside, {62, 30, 30});  // outside the new image
  add_point(MarkKind::Boundary, kBallCentre + Eigen::Vector3d(0, 0, kBallRadius), {0, 0, 1});
  add_point(MarkKind::Outside, {32, 30, 52});
  const CarriedScene carried = carry();
  ASSERT_EQ(carried.dropped.size(), 2u);
  EXPECT_EQ(carried.dropped[0].what, "outside mark 1");
  EXPECT_EQ(carried.dropped[0].why, "the images differ there");
  EXPECT_EQ(carried.dropped[1].what, "outside mark 2");
  EXPECT_EQ(carried.dropped[1].why, "it is outside the new image");
  EXPECT_EQ(carried.kept_marks, 3);
  ASSERT_EQ(carried.scene.points.size(), 3u);
  EXPECT_LT((carried.scene.points[0].position_mm - kBallCentre - kMoved).norm(), 1e-9);
  EXPECT_LT((carried.scene.points[1].outward - Eigen::Vector3d(0, 0, 1)).norm(), 1e-9);

  EXPECT_EQ(carry({.marks = CarriedMarks::All}).kept_marks, 4) << "all but the one outside the new image";
  const CarriedScene without = carry({.marks = CarriedMarks::None});
  EXPECT_EQ(without.kept_marks, 0);
  ASSERT_EQ(without.dropped.size(), 1u);
  EXPECT_EQ(without.dropped[0].what, "5 marks");
}

TEST_F(CarryOverTest, ABoundaryMarkWithoutAnEdgeIsDropped) {
  add_point(MarkKind::Boundary, kBallCentre + Eigen::Vector3d(0, 0, kBallRadius), {0, 0, 1});
  next_ = ball_at(kBallCentre + kMoved + Eigen::Vector3d(0, 0, -9), kBallRadius);
  const CarriedScene carried = carry();
  ASSERT_EQ(carried.dropped.size(), 1u);
  EXPECT_EQ(carried.dropped[0].why, "the new image has no such edge there");
}

TEST_F(CarryOverTest, PaintIsDroppedAndStrokesAreMapped) {
  UserPoint paint{200, 7, kBallCentre, MarkKind::Inside, 3};
  paint.brush.shape = PaintBrush::Shape::Ball;
  scene_.points.push_back(paint);
  UserPoint stroke{201, 7, kBallCentre, MarkKind::Inside, 2};
  stroke.path_mm = {{3, 0, 0}, {6, 0, 0}};
  scene_.points.push_back(stroke);
  Eigen::Affine3d turn(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()));
  turn = Eigen::Translation3d(kBallCentre + kMoved) * turn * Eigen::Translation3d(-kBallCentre);
  const CarriedScene carried = carry_over(scene_, earlier_, next_, Transform(turn), {});
  ASSERT_EQ(carried.dropped.size(), 1u);
  EXPECT_EQ(carried.dropped[0].what, "paint 1");
  ASSERT_EQ(carried.scene.points.size(), 1u);
  EXPECT_LT((carried.scene.points[0].path_mm[1] - Eigen::Vector3d(0, 6, 0)).norm(), 1e-9);
}

TEST_F(CarryOverTest, RefusesWhatCannotBeCarried) {
  const Transform away(Eigen::Affine3d(Eigen::Translation3d(500, 0, 0)));
  EXPECT_THROW(carry_over(scene_, earlier_, next_, away, {}), Error);
  EXPECT_THROW(carry_over(scene_, earlier_, Volume(), Transform(), {}), Error);
  EXPECT_THROW(carry_over(Scene(), earlier_, next_, Transform(), {}), Error);
  EXPECT_THROW(carry({.error_mm = -1}), Error);
  EXPECT_THROW(carry({.error_mm = std::nan("")}), Error);
}

TEST(SurfacePrior, FallsFromInsideToOutsideWithTheError) {
  const VolumeGeometry grid{.size = {40, 40, 40}};
  const auto log_odds = [&](double error_mm, double x) {
    const ShapePrior prior = surface_prior(make_sphere({20, 20, 20}, 10, 4), error_mm, 1, grid, run_serially());
    VolumeGeometry one{.size = {1, 1, 1}};
    one.origin_mm = {x, 20, 20};
    return prior.at_cells(one, run_serially())[0];
  };
  EXPECT_NEAR(log_odds(2, 30), 0, 0.5) << "on the surface";
  EXPECT_NEAR(log_odds(2, 28), 1.702, 0.5) << "one deviation inside";
  EXPECT_NEAR(log_odds(4, 34), -1.702, 0.5) << "one deviation outside";
  EXPECT_NEAR(log_odds(2, 20), std::log(99), 1e-3);
  EXPECT_NEAR(log_odds(2, 39), -std::log(99), 1e-3);
}

TEST(FollowUpCurve, HasALineAndAPointForEachTimePoint) {
  std::vector<TimePoint> points(2);
  points[0] = {1, 0.0, "a.json", {{"ventricle", {1, 2, 3}, {10.5, 30, 20, {1, 2, 3}}}}};
  points[1] = {2, 0.08, "b.json", {{"ventricle", {1, 2, 3}, {8, 0, 0, {1, 2, 3}}}}};
  EXPECT_EQ(curve_csv(points),
            "time_point,time_s,name,volume_ml,long_mm,short_mm,x_mm,y_mm,z_mm\n"
            "1,0,ventricle,10.5,30,20,1,2,3\n2,0.08,ventricle,8,,,1,2,3\n");
  Plot plot = curve_plot(points);
  EXPECT_EQ(plot.x_title, "time, ms");
  ASSERT_EQ(plot.series.size(), 1u);
  EXPECT_EQ(plot.series[0].x, (std::vector<double>{0, 80}));
  EXPECT_EQ(plot.series[0].y, (std::vector<double>{10.5, 8}));
  points[1].time_s = std::nullopt;
  EXPECT_EQ(curve_plot(points).x_title, "time point");
  EXPECT_EQ(curve_plot(points).series[0].x, (std::vector<double>{1, 2}));
}

TEST(EqualisedVolume, HasEquallyFrequentValuesInTheSameOrder) {
  Volume volume(VolumeGeometry{.size = {100, 1, 1}}, VoxelType::Int16);
  Volume reals(VolumeGeometry{.size = {100, 1, 1}}, VoxelType::Float32);
  for (int i = 0; i < 100; ++i) {
    volume.voxels<std::int16_t>()[i] = static_cast<std::int16_t>(i < 98 ? i : -1000 + 2000 * (i % 2));
    reals.voxels<float>()[i] = volume.voxels<std::int16_t>()[i];
  }
  reals.voxels<float>()[5] = NAN;
  const Volume equal = equalised(volume);
  EXPECT_EQ(equal.voxels<std::uint16_t>()[98], 0) << "the smallest";
  EXPECT_NEAR(equal.voxels<std::uint16_t>()[99], 65535 * 0.99, 1) << "the largest";
  EXPECT_NEAR(equal.voxels<std::uint16_t>()[50], 65535 * 0.51, 1);
  EXPECT_NEAR(equalised(reals).voxels<std::uint16_t>()[50], 65535 * 50.0 / 99, 1);
  EXPECT_EQ(equalised(reals).voxels<std::uint16_t>()[5], 0);
}

}  // namespace
}  // namespace simplexseg
