// SPDX-License-Identifier: Apache-2.0
// Edits of voxels: parts, holes, margin, smoothing, other objects, frozen parts and smart paint.
#include <cmath>
#include <cstdlib>
#include <random>

#include "image/label_surface.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "session/edited_voxels.h"
#include "session/label_map.h"
#include "session/paint.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

std::unique_ptr<Session> open_for_edits() {
  auto session = open_with_field();
  session->advance_steps(600, true);
  return session;
}
Mask object_of(const Session& session, std::size_t mesh = 0) {
  const MeshItem& item = session.scene().meshes[mesh];
  return object_mask(item.mesh, paint_of(session.scene(), item.id), session.volume().geometry());
}
AddPoint painted_ball(const Session& session, const Eigen::Vector3d& at_mm, double radius_mm, bool inside = true) {
  return {first_mesh(session).id, at_mm, inside ? MarkKind::Inside : MarkKind::Outside, radius_mm, {0, 0, 0}, {},
          PaintBrush::ball()};
}
EditVoxels edit_of(const Session& session, VoxelEdit edit, double size = 0, ItemId other = 0) {
  return {first_mesh(session).id, edit, size, other};
}
std::size_t count(const Mask& mask) { return static_cast<std::size_t>(std::ranges::count(mask.voxels, 1)); }

TEST(VoxelEdits, RemoveIslands) {
  const auto session = open_for_edits();
  const Mask ball = object_of(*session);
  session->apply(painted_ball(*session, {28, 0, 0}, 3));
  session->apply(painted_ball(*session, {0, 28, 0}, 1.5));
  ASSERT_EQ(connected_components(object_of(*session)).size(), 3u);
  session->apply(edit_of(*session, VoxelEdit::RemoveSmall, 50));
  EXPECT_EQ(connected_components(object_of(*session)).size(), 2u) << "the ball of 113 mm3 remains";
  session->apply(edit_of(*session, VoxelEdit::KeepLargest));
  EXPECT_EQ(object_of(*session).voxels, ball.voxels);
  EXPECT_NE(refusal(*session, edit_of(*session, VoxelEdit::KeepLargest)).find("no voxel"), std::string::npos);
}

TEST(VoxelEdits, FillHoles) {
  const auto session = open_for_edits();
  const Mask ball = object_of(*session);
  session->apply(painted_ball(*session, {3, 2, 1}, 4, false));
  ASSERT_LT(count(object_of(*session)), count(ball));
  session->apply(edit_of(*session, VoxelEdit::FillHoles));
  EXPECT_EQ(object_of(*session).voxels, ball.voxels);
}

TEST(VoxelEdits, MoveTheSurfaceByAMargin) {
  for (const double margin_mm : {2.0, -2.0}) {
    const auto session = open_for_edits();
    const Mask ball = object_of(*session);
    session->apply(edit_of(*session, VoxelEdit::Margin, margin_mm));
    const Mask moved = object_of(*session);
    const auto [ni, nj, nk] = ball.geometry.size;
    const VoxelBox all{{0, 0, 0}, ball.geometry.size};
    // A voxel has the value of the growing side if one of its neighbours within 2 mm (2 voxels) had it.
    const bool grows = margin_mm > 0;
    for (int k = 2; k < nk - 2; ++k)
      for (int j = 2; j < nj - 2; ++j)
        for (int i = 2; i < ni - 2; ++i) {
          bool reached = false;
          for (int c = -2; c <= 2; ++c)
            for (int b = -2; b <= 2; ++b)
              for (int a = -2; a <= 2; ++a)
                if (a * a + b * b + c * c <= 4) reached |= (ball.voxels[all.offset(i + a, j + b, k + c)] != 0) == grows;
          ASSERT_EQ(moved.voxels[all.offset(i, j, k)] != 0, reached == grows) << margin_mm;
        }
    session->advance_steps(1500, true);
    EXPECT_GT(dice(rasterise(first_mesh(*session).mesh, ball.geometry), moved), 0.99) << "the mesh follows";
    const Mask now = object_of(*session);
    std::size_t wrong = 0, painted = 0;
    for (std::size_t v = 0; v < now.voxels.size(); ++v) {
      if (ball.voxels[v] == moved.voxels[v]) continue;
      ++painted;
      wrong += now.voxels[v] != moved.voxels[v];
    }
    EXPECT_GT(painted, 1000u);
    EXPECT_EQ(wrong, 0u);
  }
}

TEST(VoxelEdits, SmoothRemovesASpikeAndKeepsTheVolume) {
  const auto session = open_for_edits();
  const Mask ball = object_of(*session);
  AddPoint spike = painted_ball(*session, {20, 0, 0}, 1);
  spike.path_mm = {{8, 0, 0}};
  session->apply(spike);
  const Mask with_spike = object_of(*session);
  ASSERT_GT(count(with_spike), count(ball) + 20);
  session->apply(edit_of(*session, VoxelEdit::Smooth, 2));
  const Mask smooth = object_of(*session);
  EXPECT_NEAR(static_cast<double>(count(smooth)) / static_cast<double>(count(ball)), 1, 0.03);
  const Eigen::Vector3d tip = ball.geometry.index_from_world() * Eigen::Vector3d(26, 0, 0);
  const VoxelBox all{{0, 0, 0}, ball.geometry.size};
  const std::size_t at = all.offset(static_cast<int>(std::lround(tip[0])), static_cast<int>(std::lround(tip[1])),
                                    static_cast<int>(std::lround(tip[2])));
  EXPECT_TRUE(with_spike.voxels[at]);
  EXPECT_FALSE(smooth.voxels[at]);
}

TEST(VoxelEdits, CombineTwoObjects) {
  const auto session = open_for_edits();
  const ItemId other = session->apply(AddMesh{"other", {{12, 0, 0}, 10}, std::nullopt});
  const Mask a = object_of(*session), b = object_of(*session, 1);
  ASSERT_GT(count(a), 0u);
  ASSERT_GT(count(b), 0u);
  const auto expect = [&](VoxelEdit edit, const auto& combine) {
    session->apply(edit_of(*session, edit, 0, other));
    const Mask result = object_of(*session);
    for (std::size_t v = 0; v < result.voxels.size(); ++v)
      ASSERT_EQ(result.voxels[v] != 0, combine(a.voxels[v] != 0, b.voxels[v] != 0)) << info_of(edit).name;
    session->apply(Undo{});
    EXPECT_EQ(object_of(*session).voxels, a.voxels);
  };
  expect(VoxelEdit::Add, [](bool x, bool y) { return x || y; });
  expect(VoxelEdit::Subtract, [](bool x, bool y) { return x && !y; });
  expect(VoxelEdit::Intersect, [](bool x, bool y) { return x && y; });
}

TEST(VoxelEdits, AreRefusedWithoutWhatTheyNeed) {
  const auto session = open_for_edits();
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Add}).find("another"), std::string::npos);
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Add, 0, mesh}).find("another"), std::string::npos);
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Margin, 500}).find("out of range"), std::string::npos);
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Margin, std::nan("")}).find("out of range"),
            std::string::npos);
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Margin, -40}).find("whole object"), std::string::npos);
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Freeze}).find("stroke"), std::string::npos);
  AddPoint stroke = painted_ball(*session, {20, 0, 0}, 4);
  stroke.edit = VoxelEdit::Margin;
  EXPECT_NE(refusal(*session, stroke).find("no stroke"), std::string::npos);
  stroke.edit = VoxelEdit::Freeze;
  const ItemId frozen = session->apply(stroke);
  EXPECT_NE(refusal(*session, MovePoint{frozen, {0, 0, 0}}).find("cannot move"), std::string::npos);
  EXPECT_NE(refusal(*session, ResizePoint{frozen, 3}).find("no radius"), std::string::npos);
  EditMesh lock{mesh, {}, {}, {}, {}};
  lock.locked = true;
  session->apply(lock);
  EXPECT_NE(refusal(*session, EditVoxels{mesh, VoxelEdit::Margin, 2}).find("locked"), std::string::npos);
  stroke.brush = PaintBrush::contour({0, 0, 1}, 1);
  EXPECT_FALSE(refusal(*session, stroke).empty());
}

TEST(VoxelEdits, ReplayToTheSameBits) {
  const auto live = open_for_edits();
  live->apply(edit_of(*live, VoxelEdit::Margin, 1.5));
  live->advance_steps(50);
  live->apply(edit_of(*live, VoxelEdit::Smooth, 1));
  AddPoint frozen = painted_ball(*live, {20, 0, 0}, 5);
  frozen.edit = VoxelEdit::Freeze;
  live->apply(frozen);
  live->apply(AddPoint{first_mesh(*live).id, {0, 0, 19}, MarkKind::Outside});
  live->advance_steps(50);
  const auto replayed = open_with_field();
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_EQ(first_mesh(*replayed).mesh.positions, first_mesh(*live).mesh.positions);
  EXPECT_EQ(first_mesh(*replayed).field->values, first_mesh(*live).field->values);
  ASSERT_EQ(replayed->scene().points.size(), live->scene().points.size());
  for (std::size_t p = 0; p < live->scene().points.size(); ++p)
    if (live->scene().points[p].voxels) {
      EXPECT_EQ(replayed->scene().points[p].voxels->voxels, live->scene().points[p].voxels->voxels);
    }
}

/// SIMPLEXSEG_MARKS: number of random marks.
TEST(Freeze, KeepsItsPartUnderAllLaterMarks) {
  const auto session = open_for_edits();
  const ItemId mesh = first_mesh(*session).id;
  const Mask before = object_of(*session);
  AddPoint stroke = painted_ball(*session, {20, 0, 0}, 6);
  stroke.path_mm = {{-6, 14, 0}};
  stroke.edit = VoxelEdit::Freeze;
  const ItemId frozen = session->apply(stroke);
  EXPECT_EQ(object_of(*session).voxels, before.voxels) << "freezing changes nothing";
  Mask region{before.geometry, std::vector<std::uint8_t>(before.voxels.size())};
  apply(PaintStroke{true, {{20, 0, 0}, {14, 14, 0}}, 6}, region);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-24, 24), radius(1, 6);
  const char* const marks = std::getenv("SIMPLEXSEG_MARKS");
  const int trials = marks ? std::atoi(marks) : 20;
  int changed_elsewhere = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Eigen::Vector3d at(place(random), place(random), place(random));
    session->apply(AddPoint{mesh, at, trial % 2 ? MarkKind::Inside : MarkKind::Outside, radius(random)});
    session->advance_steps(12);
    const Mask now = object_of(*session);
    std::size_t wrong = 0;
    for (std::size_t v = 0; v < now.voxels.size(); ++v) wrong += region.voxels[v] && now.voxels[v] != before.voxels[v];
    ASSERT_EQ(wrong, 0u) << trial;
    changed_elsewhere += now.voxels != before.voxels;
    session->apply(Undo{});
  }
  EXPECT_GT(changed_elsewhere, trials / 2);
  session->apply(DeletePoint{frozen});
  session->apply(AddPoint{mesh, {20, 0, 0}, MarkKind::Outside, 5});
  session->advance_steps(100);
  const Mask now = object_of(*session);
  std::size_t changed = 0;
  for (std::size_t v = 0; v < now.voxels.size(); ++v) changed += region.voxels[v] && now.voxels[v] != before.voxels[v];
  EXPECT_GT(changed, 50u) << "free again";
}

TEST(Freeze, ChangesNoLabelOfAnotherObject) {
  const auto session = open_for_edits();
  const ItemId second = session->apply(DuplicateMesh{first_mesh(*session).id});
  const LabelMap before = make_label_map(session->scene(), session->volume().geometry());
  AddPoint stroke = painted_ball(*session, {20, 0, 0}, 6);
  stroke.mesh = second;
  stroke.edit = VoxelEdit::Freeze;
  session->apply(stroke);
  const LabelMap after = make_label_map(session->scene(), session->volume().geometry());
  EXPECT_TRUE(std::ranges::equal(before.labels.voxels<std::uint8_t>(), after.labels.voxels<std::uint8_t>()));
}

TEST(Freeze, KeepsTheLabelsWhereObjectsOverlap) {
  const auto session = open_for_edits();
  const ItemId first = first_mesh(*session).id;
  session->apply(DuplicateMesh{first});
  const auto labels = [&] {
    const LabelMap map = make_label_map(session->scene(), session->volume().geometry());
    const auto voxels = map.labels.voxels<std::uint8_t>();
    return std::vector<std::uint8_t>(voxels.begin(), voxels.end());
  };
  AddPoint stroke = painted_ball(*session, {18, 0, 0}, 6);
  stroke.edit = VoxelEdit::Freeze;
  for (const MeshItem& item : std::vector<MeshItem>(session->scene().meshes)) {
    stroke.mesh = item.id;
    session->apply(stroke);
  }
  const std::vector<std::uint8_t> before = labels();
  Mask region{session->volume().geometry(), std::vector<std::uint8_t>(before.size())};
  apply(PaintStroke{true, {{18, 0, 0}}, 6}, region);
  session->apply(AddPoint{first, {17, 3, 0}, MarkKind::Outside, 4});
  session->apply(AddPoint{first, {0, 0, 19}, MarkKind::Outside, 4});
  session->advance_steps(60);
  const std::vector<std::uint8_t> after = labels();
  std::size_t wrong = 0, changed = 0;
  for (std::size_t v = 0; v < after.size(); ++v) {
    wrong += region.voxels[v] && after[v] != before[v];
    changed += after[v] != before[v];
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(changed, 10u) << "elsewhere";
}

/// Session with a ball of 8 mm as labels, on a sheared grid.
std::unique_ptr<Session> open_sheared() {
  VolumeGeometry grid;
  grid.size = {40, 40, 40};
  grid.direction.col(1) = Eigen::Vector3d(std::sin(0.6), std::cos(0.6), 0);
  grid.origin_mm = {-30, -16, -20};
  Scene scene;
  scene.simulation = default_simulation_parameters();
  auto session = std::make_unique<Session>(make_cpu_engine(2), nullptr, 2);
  session->open(std::move(scene), Volume(grid, VoxelType::UInt8));
  session->apply(AddMesh{"ball", {{0, 0, 0}, 8}, std::nullopt});
  return session;
}

TEST(VoxelEdits, MeasureInMillimetresOnShearedGrids) {
  const auto session = open_sheared();
  const VolumeGeometry grid = session->volume().geometry();
  const Mask ball = object_of(*session);
  session->apply(painted_ball(*session, {0, 13, 0}, 2));
  const double voxel_mm3 = std::abs(grid.world_from_index().linear().determinant());
  const double part_mm3 = static_cast<double>(count(object_of(*session)) - count(ball)) * voxel_mm3;
  EXPECT_FALSE(refusal(*session, edit_of(*session, VoxelEdit::RemoveSmall, 0.9 * part_mm3)).empty());
  session->apply(edit_of(*session, VoxelEdit::RemoveSmall, 1.1 * part_mm3));
  EXPECT_EQ(object_of(*session).voxels, ball.voxels);
  session->apply(edit_of(*session, VoxelEdit::Margin, 5));
  const Mask grown = object_of(*session);
  const Eigen::Affine3d world = grid.world_from_index();
  const VoxelBox all{{0, 0, 0}, grid.size};
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        const double distance = (world * Eigen::Vector3d(i, j, k)).norm();
        if (distance < 11.5) {
          ASSERT_TRUE(grown.voxels[all.offset(i, j, k)]) << distance;
        }
        if (distance > 13.2) {
          ASSERT_FALSE(grown.voxels[all.offset(i, j, k)]) << distance;
        }
      }
}

TEST(SmartPaint, StopsAtEdgesOfTheImage) {
  const auto session = open_for_edits();
  // The object without a part: the stroke along the surface, inside the ball of the image, restores it.
  session->apply(painted_ball(*session, {20, 0, 0}, 9, false));
  const Mask eroded = object_of(*session);
  AddPoint stroke = painted_ball(*session, {16, 0, 0}, 8);
  stroke.edit = VoxelEdit::SmartPaint;
  session->apply(stroke);
  const Mask painted = object_of(*session);
  const VolumeGeometry& grid = painted.geometry;
  const Eigen::Affine3d world = grid.world_from_index();
  int right = 0, wrong = 0, missed = 0;
  std::size_t v = 0;
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i, ++v) {
        const Eigen::Vector3d mm = world * Eigen::Vector3d(i, j, k);
        const bool set = painted.voxels[v] && !eroded.voxels[v], in_ball = mm.norm() < 19.5;
        const bool wanted = in_ball && (mm - Eigen::Vector3d(16, 0, 0)).norm() < 8 && !eroded.voxels[v];
        right += set && in_ball, wrong += set && mm.norm() > 20.5, missed += wanted && !set;
      }
  EXPECT_GT(right, 500);
  EXPECT_LT(wrong, right / 50);
  EXPECT_LT(missed, right / 10);
}

}  // namespace
}  // namespace simplexseg
