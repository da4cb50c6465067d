// SPDX-License-Identifier: Apache-2.0
// Planes that cut the 3D view: tests send events and check pixels.
#include <QAction>
#include <QMenu>
#include <QSettings>
#include <cmath>

#include "gui/window/window_memory.h"
#include "space_fixture.h"

namespace simplexseg {
namespace {

TEST_F(SpaceTest, TheCapOfACutSphereIsClosedAndFlipShowsTheOtherHalf) {
  const QImage whole = picture();
  EXPECT_LT(share_of_ring(whole, colour_of(0), {0, 0, 1}, 0, 11.5, centre()), 0.1) << "lit, not flat";
  press(Act::ClipAxial);
  const QImage cut = picture();
  EXPECT_GT(share_of_ring(cut, colour_of(0), {0, 0, 1}, 0, 11.3, centre()), 0.99);
  save(whole, "whole"), save(cut, "cut_axial");
  EXPECT_TRUE(close(colour_at(cut, centre() + top()), kBackground))
      << "the upper half is removed; " << colour_at(cut, centre() + top()).name().toStdString();
  EXPECT_FALSE(close(colour_at(whole, centre() + top()), kBackground));
  // Flipped, the lower half is removed, and the view from above shows the lit upper half.
  EXPECT_TRUE(window_->actions()[Act::FlipAxial]->isEnabled());
  press(Act::FlipAxial);
  const QImage flipped = picture();
  EXPECT_FALSE(close(colour_at(flipped, centre() + top()), kBackground));
  EXPECT_TRUE(close(colour_at(flipped, centre() + Vector3d(0, -7, -9)), kBackground));
  EXPECT_FALSE(close(colour_at(cut, centre() + Vector3d(0, -7, -9)), kBackground));
  EXPECT_LT(share_of_ring(flipped, colour_of(0), {0, 0, 1}, 0, 11.3, centre()), 0.1);
  press(Act::ClipAxial);
  EXPECT_EQ(picture(), whole);
}

TEST_F(SpaceTest, ALassoIsDrawnClosed) {
  std::vector<Vector3d> contour;  // three quarters of a circle
  for (int degrees = 0; degrees <= 270; degrees += 15)
    contour.push_back(centre() + 22 * Vector3d(std::cos(degrees * M_PI / 180), std::sin(degrees * M_PI / 180), 0));
  ASSERT_TRUE(bench().apply(AddLasso{scene().meshes[0].id, MarkKind::Inside, contour, {0, 0, 1}}));
  bench().pause();
  const QImage drawn = picture();
  save(drawn, "lasso_3d");
  for (const double share : {0.2, 0.5, 0.8}) {
    const Vector3d at = contour.back() + share * (contour.front() - contour.back());
    EXPECT_TRUE(close(colour_at(drawn, at), theme::kInside, 40)) << share << colour_at(drawn, at).name().toStdString();
  }
  press(Act::DeletePoint);
  EXPECT_TRUE(scene().points.empty());
  const QImage empty = picture();
  save(empty, "lasso_3d_empty");
  EXPECT_FALSE(close(colour_at(empty, 0.5 * (contour.back() + contour.front())), theme::kInside, 40));
}

TEST_F(SpaceTest, ACutFaceHidesTheMaximumIntensityBehindIt) {
  drag(space(), QPointF(100, 150), QPointF(100, 100));  // nearly along the plane
  press(Act::ClipAxial);
  const QImage cut = picture();
  bench().view.volume_mode = VolumeMode::Maximum;
  bench().view_edited();
  const QImage with_volume = picture();
  save(with_volume, "cut_maximum");
  EXPECT_NE(with_volume, cut) << "beside the mesh, the volume is shown";
  EXPECT_GT(share_of_ring(with_volume, colour_of(0), {0, 0, 1}, 0, 10.5, centre()), 0.99);
}

TEST_F(SpaceTest, NestedTouchingAndOverlappingMeshesHaveTheirOwnCaps) {
  const int inner = add_sphere(centre(), 5);
  const int touching = add_sphere(centre() + Vector3d(20.2, 0, 0), 8);
  const int overlapping = add_sphere(centre() + Vector3d(-14, 0, 0), 7);
  for (const bool reordered : {false, true}) {
    if (reordered) {
      ASSERT_TRUE(bench().apply(ReorderMesh{scene().meshes[1].id, 0}));
    }
    const auto at = [&](int mesh) { return reordered && mesh < 2 ? 1 - mesh : mesh; };
    bench().view.clip.on[0] = true;
    bench().view_edited();
    const QImage cut = picture();
    const Vector3d up(0, 0, 1);
    EXPECT_GT(share_of_ring(cut, colour_of(at(inner)), up, 0, 4.6, centre()), 0.97) << reordered;
    const double outer = share_of_ring(cut, colour_of(at(0)), up, 5.5, 6.4, centre());
    EXPECT_GT(outer, 0.97) << reordered;
    EXPECT_GT(share_of_ring(cut, colour_of(touching), up, 0, 7.3, centre() + Vector3d(20.2, 0, 0)), 0.98);
    EXPECT_GT(share_of_ring(cut, colour_of(overlapping), up, 0, 6.3, centre() + Vector3d(-14, 0, 0)), 0.98);
  }
}

TEST_F(SpaceTest, SeveralPlanesLeaveOneClosedPart) {
  for (const Act act : {Act::ClipAxial, Act::ClipSagittal, Act::ClipCoronal}) press(act);
  const QImage cut = picture();
  int all = 0, coloured = 0;
  // The kept part is inferior, right and posterior: -z, -x, +y.
  for (double a = 0.3; a < 10.8; a += 0.5)
    for (double b = 0.3; std::hypot(a, b) < 10.8; b += 0.5)
      for (const Vector3d& at : {Vector3d(-a, b, 0), Vector3d(0, b, -a), Vector3d(-a, 0, -b)}) {
        ++all;
        coloured += close(colour_at(cut, centre() + at), colour_of(0));
      }
  EXPECT_GT(coloured, 0.98 * all);
  for (const Vector3d& removed : {top(), Vector3d(11, 0, 0)})
    EXPECT_TRUE(close(colour_at(cut, centre() + removed), kBackground)) << removed.transpose();
  // The count of faces leaves nothing behind: without planes, the picture is that of the beginning.
  for (QAction* entry : window_->findChild<QMenu*>("clip_menu")->actions())
    if (entry->text() == "&Nothing cut") entry->trigger();
  EXPECT_FALSE(window_->actions()[Act::ClipAxial]->isChecked());
  EXPECT_FALSE(close(colour_at(picture(), centre() + top()), kBackground));
}

TEST_F(SpaceTest, TheCapShowsTheImageInTheColourOfTheObject) {
  ASSERT_TRUE(bench().apply(AddMesh{"", {centre() + Vector3d(16, 0, 0), 6}, {}}));  // across the edge of the ball
  bench().pause();
  const int mesh = static_cast<int>(scene().meshes.size()) - 1;
  bench().view.window = 200, bench().view.level = 100;  // background 50: dark grey; ball 150: bright grey
  for (const Act act : {Act::ClipAxial, Act::ClipFree}) {
    press(act);
    if (act == Act::ClipFree) {
      bench().view.clip.free_normal = Vector3d(0.1, 0.1, 1).normalized();
      bench().view.clip.free_point_mm = centre();
    }
    press(Act::ImageOnCaps);
    ASSERT_TRUE(bench().view.clip.image_on_caps);
    const Vector3d n = act == Act::ClipFree ? bench().view.clip.free_normal : Vector3d(0, 0, 1);
    const auto on_plane = [&](double x) -> Vector3d { return centre() + Vector3d(x, 0, -n.x() * x / n.z()); };
    const QImage image = picture();
    const int inside = colour_at(image, on_plane(13)).lightness(), outside = colour_at(image, on_plane(20)).lightness();
    EXPECT_GT(inside, colour_of(mesh).lightness() + 10);
    EXPECT_LT(outside, colour_of(mesh).lightness() - 10);
    press(Act::ImageOnCaps);
    const QImage plain = picture();
    EXPECT_TRUE(close(colour_at(plain, on_plane(13)), colour_of(mesh)));
    EXPECT_TRUE(close(colour_at(plain, on_plane(20)), colour_of(mesh)));
    press(act);
  }
}

TEST_F(SpaceTest, TheFreePlaneIsPlacedMovedAndTiltedWithTheMouse) {
  bench().view.show_annotations = true;  // with them, the handle is shown
  press(Act::ClipFree);
  ClipState& clip = bench().view.clip;
  ASSERT_TRUE(clip.on[3] && clip.free_placed);
  const Vector3d towards = space().map().axis(2), start = clip.free_point_mm;
  EXPECT_LT((clip.free_normal - towards).norm(), 1e-9);
  EXPECT_LT((start - bench().view.crosshair_mm).norm(), 1e-9);
  bench().view.show_annotations = false;
  EXPECT_GT(share_of_ring(picture(), colour_of(0), towards, 0, 11.2, centre()), 0.99);
  bench().view.show_annotations = true;
  // The normal points at the viewer: upwards moves the plane away by as much as the mouse moves.
  const double mm_per_pixel = space().map().mm_per_pixel(start);
  drag(space(), pixel(start), pixel(start) - QPointF(0, 30));
  EXPECT_LT((clip.free_point_mm - (start - 30 * mm_per_pixel * towards)).norm(), 0.02 * 30 * mm_per_pixel);
  wheel(space(), pixel(clip.free_point_mm), 2);
  EXPECT_LT((clip.free_point_mm - (start - (30 * mm_per_pixel - 2) * towards)).norm(), 0.5);
  // A disc on the ring follows the mouse on the sphere around the centre.
  press(Act::FaceFreePlane);
  const double radius_mm = 56 * space().map().mm_per_pixel(clip.free_point_mm);
  const Vector3d right = space().map().axis(0);
  const QPointF disc = pixel(clip.free_point_mm + radius_mm * right);
  drag(space(), disc, disc - QPointF(28, 0));
  EXPECT_LT(clip.free_normal.dot(right), -0.7) << "the right side turns to the viewer";
  EXPECT_NEAR(clip.free_normal.dot(towards), 0.5, 0.06) << "half of the radius: 60 degrees";
  EXPECT_NEAR(clip.free_normal.norm(), 1, 1e-9);
  // The arrow now lies on the screen, and the plane follows the mouse along it.
  const Vector3d before = clip.free_point_mm, normal = clip.free_normal;
  const Vector3d tip = before + radius_mm * normal;
  drag(space(), pixel(tip), pixel(tip + 6 * normal));
  EXPECT_NEAR((clip.free_point_mm - before).dot(normal), 6, 1);
  EXPECT_LT((clip.free_normal - normal).norm(), 1e-9);
  // Elsewhere, a drag rotates the camera, and the plane stays in the patient.
  const Vector3d placed = clip.free_point_mm;
  drag(space(), QPointF(40, 40), QPointF(90, 60));
  EXPECT_EQ(clip.free_point_mm, placed);
  EXPECT_GT((space().map().axis(2) - towards).norm(), 0.1);
}

TEST_F(SpaceTest, WhatIsCutAwayCannotBePicked) {
  add_sphere(centre(), 5);
  const ItemId outer = scene().meshes[0].id, inner = scene().meshes[1].id;
  const auto click = [&](const Vector3d& at, Qt::KeyboardModifiers modifiers) {
    mouse(space(), QEvent::MouseButtonPress, pixel(at), Qt::LeftButton, Qt::LeftButton, modifiers);
    mouse(space(), QEvent::MouseButtonRelease, pixel(at), Qt::LeftButton, Qt::NoButton, modifiers);
  };
  ASSERT_TRUE(bench().apply(AddPoint{outer, centre() + Vector3d(0, 0, 12), MarkKind::Boundary}));
  bench().pause();
  const ItemId point = scene().points.back().id;
  bench().view.selected_point = 0;
  click(centre() + Vector3d(0, 0, 12), {});
  EXPECT_EQ(bench().view.selected_point, point);
  bench().view.selected_point = 0;
  press(Act::ClipAxial);
  picture();
  click(centre() + Vector3d(0, 0, 12), {});
  EXPECT_EQ(bench().view.selected_point, 0u);
  bench().set_active_mesh(outer);
  click(centre() + Vector3d(2, 1, 0), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, inner) << "the cap of the inner sphere";
  click(centre() + Vector3d(8, -1, 0), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, outer) << "the cap of the outer sphere";
  bench().set_active_mesh(inner);
  click(centre() + Vector3d(0, 0, 11.5), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, inner) << "nothing is there";
  press(Act::ClipAxial);
  picture();
  click(centre() + Vector3d(0, 0, 11.5), Qt::ControlModifier);
  EXPECT_EQ(bench().view.active_mesh, outer);
}

TEST_F(SpaceTest, PlanesAndVolumeAreRemembered) {
  QSettings::setPath(QSettings::IniFormat, QSettings::UserScope, folder_.filePath("settings"));
  {
    WindowMemory memory(*window_);
    EXPECT_FALSE(bench().view.clip.any());
    bench().view.clip.on = {true, false, true, true};
    bench().view.clip.flipped = {false, false, true, false};
    bench().view.clip.image_on_caps = false;
    bench().view.volume_mode = VolumeMode::Maximum;
  }
  window_.reset();
  SpaceTest::SetUp();
  bench().view.clip = {};
  WindowMemory memory(*window_);
  EXPECT_EQ(bench().view.clip.on, (std::array{true, false, true, true}));
  EXPECT_EQ(bench().view.clip.flipped, (std::array{false, false, true, false}));
  EXPECT_FALSE(bench().view.clip.image_on_caps);
  EXPECT_EQ(bench().view.volume_mode, VolumeMode::Maximum);
  EXPECT_TRUE(window_->actions()[Act::ClipCoronal]->isChecked());
  // The free plane is placed in each volume that is opened.
  open_phantom();
  EXPECT_TRUE(bench().view.clip.free_placed);
  EXPECT_LT((bench().view.clip.free_normal - space().map().axis(2)).norm(), 1e-9);
}

TEST(ClipPlanesTest, RaysAndSegmentsKeepWhatNoPlaneRemoves) {
  ClipState state;
  EXPECT_TRUE(clip_planes(state, {0, 0, 0}).empty());
  state.on = {true, true, false, false};
  state.flipped[1] = true;
  const std::vector<ClipPlane> planes = clip_planes(state, {1, 2, 3});  // kept: z < 3 and x > 1
  ASSERT_EQ(planes.size(), 2u);
  EXPECT_TRUE(is_clipped(planes, {2, 0, 3.1}));
  EXPECT_TRUE(is_clipped(planes, {0.9, 0, 0}));
  EXPECT_FALSE(is_clipped(planes, {1, 7, 3})) << "on the planes";
  const RayRange through = kept_range(planes, {5, 0, 10}, {-0.6, 0, -0.8});
  EXPECT_GT(through.first_mm, through.last_mm) << "x = 1 is passed before z = 3";
  const RayRange range = kept_range(planes, {13, 0, 10}, {-0.6, 0, -0.8});
  EXPECT_NEAR(range.first_mm, 8.75, 1e-9);
  EXPECT_NEAR(range.last_mm, 20, 1e-9);
  const RayRange beyond = kept_range(planes, {5, 0, 4}, {1, 0, 0});
  EXPECT_GT(beyond.first_mm, beyond.last_mm);
  const std::vector<Eigen::Vector3f> kept =
      clip_segments(planes, {{0, 0, 0}, {4, 0, 0}, {2, 0, 2}, {2, 0, 6}, {0, 0, 0}, {0, 5, 0}});
  ASSERT_EQ(kept.size(), 4u);
  EXPECT_LT((kept[0] - Eigen::Vector3f(1, 0, 0)).norm(), 1e-5f);
  EXPECT_LT((kept[1] - Eigen::Vector3f(4, 0, 0)).norm(), 1e-5f);
  EXPECT_LT((kept[2] - Eigen::Vector3f(2, 0, 2)).norm(), 1e-5f);
  EXPECT_LT((kept[3] - Eigen::Vector3f(2, 0, 3)).norm(), 1e-5f);
}

TEST(VolumeBlocksTest, ReduceToAtMostTheTexelsAndKeepMeanOrMaximum) {
  VolumeGeometry geometry;
  geometry.size = {10, 7, 3};
  geometry.spacing_mm = {1, 1, 3};
  Volume volume(geometry, VoxelType::Float32);
  for (std::size_t n = 0; n < volume.voxels<float>().size(); ++n)
    volume.voxels<float>()[n] = static_cast<float>(n % 11);
  volume.voxels<float>()[volume.offset(5, 3, 1)] = NAN;
  VolumeGeometry longer = geometry;
  longer.size[2] = 3000;
  EXPECT_EQ(choose_blocks(longer, 1'000'000).size, (std::array{10, 7, 1500})) << "longest side of a texture";
  const VolumeBlocks all = choose_blocks(geometry, 210);
  EXPECT_EQ(all.voxels, (std::array{1, 1, 1}));
  const VolumeBlocks blocks = choose_blocks(geometry, 60);
  EXPECT_EQ(blocks.voxels, (std::array{2, 2, 1})) << "as cubic as the spacing permits";
  EXPECT_EQ(blocks.size, (std::array{5, 4, 3}));
  const Volume::Range range{0, 10};
  for (const BlockValue value : {BlockValue::Mean, BlockValue::Maximum}) {
    const std::vector<std::uint16_t> values = block_values(volume, blocks, value, range, 1, 3);
    ASSERT_EQ(values.size(), 40u);
    for (int k = 1; k < 3; ++k)
      for (int j = 0; j < 4; ++j)
        for (int i = 0; i < 5; ++i) {
          double sum = 0, most = 0;
          int count = 0;
          for (int y = 2 * j; y < std::min(2 * j + 2, 7); ++y)
            for (int x = 2 * i; x < 2 * i + 2; ++x, ++count) {
              const double v = volume.value(x, y, k), finite = std::isfinite(v) ? v : 0;
              sum += finite, most = std::max(most, finite);
            }
          const double expected = (value == BlockValue::Mean ? sum / count : most) / 10 * 65535;
          EXPECT_NEAR(values[static_cast<std::size_t>(((k - 1) * 4 + j) * 5 + i)], expected, 1);
        }
  }
}

}  // namespace
}  // namespace simplexseg
