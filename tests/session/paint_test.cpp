// SPDX-License-Identifier: Apache-2.0
// Paint and eraser: exact voxels in labels, followed by the mesh.
#include "session/paint.h"

#include <cmath>

#include "core/error.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "image/surface_error.h"
#include "session/label_map.h"
#include "session/mesh_marks.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

std::unique_ptr<Session> open_settled() {
  auto session = open_with_field();
  session->advance_steps(600, true);
  return session;
}
AddPoint ball_of_paint(ItemId mesh, const Eigen::Vector3d& at_mm, double radius_mm, bool inside = true) {
  return {mesh, at_mm, inside ? MarkKind::Inside : MarkKind::Outside, radius_mm, {0, 0, 0}, {}, PaintBrush::ball()};
}
/// Number of voxels of the paint that have another value in the labels of a scene with one mesh.
int wrong_voxels(const Session& session) {
  const VolumeGeometry& grid = session.volume().geometry();
  const LabelMap map = make_label_map(session.scene(), grid);
  Mask expected{grid, std::vector<std::uint8_t>(grid.voxel_count(), 2)};  // 2: not painted
  for (const PaintStroke& stroke : paint_of(session.scene(), first_mesh(session).id)) apply(stroke, expected);
  int wrong = 0, painted = 0;
  for (std::size_t v = 0; v < expected.voxels.size(); ++v) {
    painted += expected.voxels[v] != 2;
    wrong += expected.voxels[v] != 2 && (map.labels.voxels<std::uint8_t>()[v] != 0) != (expected.voxels[v] != 0);
  }
  EXPECT_GT(painted, 10);
  return wrong;
}

TEST(Paint, LabelsEqualThePaintOnEveryVoxelWhateverFollows) {
  const auto session = open_settled();
  const ItemId mesh = first_mesh(*session).id;
  session->apply(ball_of_paint(mesh, {20, 0, 0}, 4));
  EXPECT_EQ(wrong_voxels(*session), 0) << "at once";
  session->apply(ball_of_paint(mesh, {-18, 3, 0}, 5, false));
  session->apply(AddPoint{
      mesh, {0, 20, -8}, MarkKind::Outside, 1.2, {0, 0, 0}, {{0, -6, 0}, {5, -6, 3}}, PaintBrush::disc({0, 0, 1}, 1)});
  session->apply(ball_of_paint(mesh, {22, 2, 1}, 2, false));  // takes a part of the first paint away
  EXPECT_EQ(wrong_voxels(*session), 0);
  session->advance_steps(300, true);
  session->apply(AddPoint{mesh, {0, 0, 19}, MarkKind::Outside});
  session->apply(AddPoint{mesh, {21, 0, 0}, MarkKind::Outside, 3});  // a mark in the paint
  session->advance_steps(300, true);
  EXPECT_EQ(wrong_voxels(*session), 0);
  EXPECT_EQ(marks_of(session->scene(), first_mesh(*session), ball_image()).size(), 3u) << "paint is no mark";
}

/// Largest distance in mm (one voxel) from the object with the paint to the vertices for which is_near().
template <class IsNear>
double farthest_vertex(const Session& session, const Mask& expected, const IsNear& is_near) {
  const SurfaceError error(expected);
  double farthest = 0;
  int near = 0;
  for (const Eigen::Vector3f& p : first_mesh(session).mesh.positions)
    if (is_near(p.cast<double>())) ++near, farthest = std::max(farthest, error.at(p.cast<double>()));
  EXPECT_GT(near, 20);
  return farthest;
}

TEST(Paint, TheMeshFollowsItWithinHalfAVoxel) {
  for (const bool inside : {true, false}) {
    const auto session = open_settled();
    const ItemId mesh = first_mesh(*session).id;
    const Eigen::Vector3d at(inside ? 19 : 17, 0, 0);
    session->apply(ball_of_paint(mesh, at, 6, inside));
    session->advance_steps(1500, true);
    const VolumeGeometry& grid = ball_image().geometry();
    const SimplexMesh& settled = first_mesh(*session).mesh;
    const Mask expected = object_mask(settled, paint_of(session->scene(), mesh), grid);
    EXPECT_GT(dice(rasterise(settled, grid), expected), 0.999);
    // Not at the edge where the painted ball meets the surface.
    const auto is_near = [&](const Eigen::Vector3d& p) {
      return (p - at).norm() < 7 && (inside ? p.norm() > 22 : p.norm() < 17.5);
    };
    EXPECT_LE(farthest_vertex(*session, expected, is_near), 0.5) << inside;
  }
}

TEST(Paint, CanBeTakenBackByStroke) {
  const auto session = open_settled();
  const ItemId mesh = first_mesh(*session).id;
  const auto solved = first_mesh(*session).field;
  const ItemId first = session->apply(ball_of_paint(mesh, {20, 0, 0}, 4));
  const auto painted_once = first_mesh(*session).field;
  EXPECT_NE(painted_once->values, solved->values);
  session->apply(ball_of_paint(mesh, {0, -20, 0}, 4, false));
  EXPECT_NE(first_mesh(*session).field->values, painted_once->values);
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, painted_once);
  session->apply(DeletePoint{first});
  EXPECT_EQ(first_mesh(*session).field, solved);
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, painted_once);
  EXPECT_EQ(wrong_voxels(*session), 0);
  session->apply(MovePoint{first, {0, 0, 20}});
  EXPECT_EQ(wrong_voxels(*session), 0);
}

TEST(Paint, IsAddedToEachNewFieldAndChangesNothingElse) {
  const auto session = open_settled();
  const ItemId mesh = first_mesh(*session).id;
  session->apply(ball_of_paint(mesh, {20, 0, 0}, 4));
  const auto& field = *first_mesh(*session).field;
  ASSERT_TRUE(field.solved);
  const VolumeGeometry grid = field.grid(ball_image().geometry());
  std::size_t changed = 0;
  ASSERT_EQ(field.box, field.solved->box);
  for (std::size_t v = 0; v < field.values.size(); ++v) {
    if (field.values[v] == field.solved->values[v]) continue;
    ++changed;
    const int i = static_cast<int>(v % grid.size[0]), j = static_cast<int>(v / grid.size[0] % grid.size[1]),
              k = static_cast<int>(v / grid.size[0] / grid.size[1]);
    const double distance = (grid.world_from_index() * Eigen::Vector3d(i, j, k) - Eigen::Vector3d(20, 0, 0)).norm();
    // Beyond the paint only the distances outside the object change.
    if (distance > 4) {
      EXPECT_LT(field.values[v], 32768) << distance;
    }
  }
  EXPECT_GT(changed, 50u);
  session->apply(AddPoint{mesh, {0, 0, 19}, MarkKind::Outside});
  session->advance_steps(1);
  EXPECT_NE(first_mesh(*session).field->solved, field.solved);
  EXPECT_EQ(first_mesh(*session).field->paint.size(), 1u);
}

TEST(Paint, BeyondTheBoxEnlargesItUpToALimit) {
  VolumeGeometry volume;
  volume.size = {400, 400, 400};
  auto solved = std::make_shared<MeshField>();
  solved->box = {{100, 100, 100}, {20, 20, 20}};
  solved->values.assign(solved->box.voxel_count(), 65535);
  solved->marks = {{MarkKind::Inside, {110, 110, 110}, 1}};
  const auto near = painted_field(solved, {{true, {{130, 110, 110}}, 2}}, volume);
  EXPECT_EQ(near->box.first, (std::array{100, 100, 100}));
  EXPECT_EQ(near->box.size, (std::array{36, 20, 20})) << "with a margin of three cells";
  EXPECT_GT(near->values[near->box.offset(30, 10, 10)], 32768);
  EXPECT_LT(near->values[near->box.offset(25, 10, 10)], 32768) << "between the field and the paint";
  EXPECT_EQ(near->solved, solved);
  const auto far = painted_field(solved, {{true, {{390, 390, 390}}, 2}}, volume);
  EXPECT_EQ(far->box, solved->box);
  EXPECT_EQ(far->values, solved->values);
}

TEST(Paint, ReplaysToTheSameBits) {
  const auto live = open_settled();
  const ItemId mesh = first_mesh(*live).id;
  live->apply(ball_of_paint(mesh, {20, 0, 0}, 4));
  live->advance_steps(40);
  live->apply(ball_of_paint(mesh, {22, 0, 0}, 3, false));
  live->apply(Undo{});
  live->advance_steps(60);
  const auto replayed = open_with_field();
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_EQ(first_mesh(*replayed).mesh.positions, first_mesh(*live).mesh.positions);
  EXPECT_EQ(first_mesh(*replayed).field->values, first_mesh(*live).field->values);
}

TEST(Paint, BelongsToItsObjectWhateverTheOthersContain) {
  const auto session = open_settled();
  const ItemId first = first_mesh(*session).id;
  const ItemId second = session->apply(DuplicateMesh{first});
  const Eigen::Vector3d at(5, 0, 0);
  const auto label_at = [&](const Eigen::Vector3d& mm) {
    const LabelMap map = make_label_map(session->scene(), ball_image().geometry());
    const Eigen::Vector3d v = ball_image().geometry().index_from_world() * mm;
    return static_cast<int>(map.labels.voxels<std::uint8_t>()[ball_image().offset(
        static_cast<int>(std::lround(v[0])), static_cast<int>(std::lround(v[1])),
        static_cast<int>(std::lround(v[2])))]);
  };
  EXPECT_EQ(label_at(at), 1);
  session->apply(ball_of_paint(second, at, 3));
  EXPECT_EQ(label_at(at), 2);
  session->apply(ball_of_paint(second, at, 1, false));
  EXPECT_EQ(label_at(at), 1) << "erased from the second, it remains in the first";
  EXPECT_EQ(label_at(at + Eigen::Vector3d(0, 2, 0)), 2);
  session->apply(ball_of_paint(first, at, 3));
  EXPECT_EQ(label_at(at + Eigen::Vector3d(0, 2, 0)), 1) << "the last stroke counts";
}

/// Opens a scene with a mesh in the first of some balls along the i axis of a long volume.
void open_long_volume(Session& session, std::initializer_list<int> centres) {
  VolumeGeometry geometry;
  geometry.size = {160, 32, 32};
  Volume image(geometry, VoxelType::Float32);
  const std::span<float> voxels = image.voxels<float>();
  std::size_t v = 0;
  for (int k = 0; k < 32; ++k)
    for (int j = 0; j < 32; ++j)
      for (int i = 0; i < 160; ++i, ++v)
        for (const int centre : centres)
          if ((i - centre) * (i - centre) + (j - 16) * (j - 16) + (k - 16) * (k - 16) < 64)
            voxels[v] = static_cast<float>(100 + (i * 7 + j * 3 + k) % 5);
  Scene scene = ball_scene();
  set(scene.forces, {"evidence", "source", 0});
  scene.meshes[0].parameters = scene.forces;
  scene.meshes[0].mesh = {}, scene.meshes[0].seed = {{20, 16, 16}, 6};
  session.open(std::move(scene), std::move(image));
}

/// The box that paint enlarges may reach marks of other meshes, which its field did not receive.
TEST(Paint, NearAnotherMeshStartsNoFurtherUpdates) {
  Session session(make_cpu_engine(2), nullptr, 2);
  open_long_volume(session, {20, 140});
  const ItemId first = session.scene().meshes[0].id;
  session.apply(AddMesh{"other", {{140, 16, 16}, 6}, std::nullopt, first});
  session.advance_steps(100);
  ASSERT_LT(session.scene().meshes[0].field->box.size[0], 100);
  session.apply(ball_of_paint(first, {128, 16, 16}, 4, false));
  ASSERT_GT(session.scene().meshes[0].field->box.size[0], 120);
  const auto solved = session.scene().meshes[0].field->solved;
  session.advance_steps(5);
  EXPECT_EQ(session.scene().meshes[0].field->solved, solved);
  EXPECT_FALSE(has_stale_field(session.scene(), session.scene().meshes[0], session.volume()));
}

TEST(Paint, FarAwayLeavesTheMeshWithItsStroke) {
  Session session(make_cpu_engine(2), nullptr, 2);
  open_long_volume(session, {20});
  session.advance_steps(400, true);
  const auto voxels_far_away = [&] {
    const Mask mask = rasterise(first_mesh(session).mesh, session.volume().geometry());
    int count = 0;
    for (std::size_t p = 0; p < mask.voxels.size(); ++p) count += mask.voxels[p] != 0 && p % 160 > 80;
    return count;
  };
  const ItemId stroke = session.apply(ball_of_paint(first_mesh(session).id, {130, 16, 16}, 7));
  session.advance_steps(1500, true);
  EXPECT_GT(voxels_far_away(), 1000);
  session.apply(DeletePoint{stroke});
  session.advance_steps(1500, true);
  EXPECT_EQ(voxels_far_away(), 0);
}

TEST(Paint, OfALockedMeshCannotBeChanged) {
  const auto session = open_settled();
  const ItemId mesh = first_mesh(*session).id;
  const ItemId stroke = session->apply(ball_of_paint(mesh, {20, 0, 0}, 4));
  const ItemId mark = session->apply(AddPoint{mesh, {5, 0, 0}, MarkKind::Inside, 2});
  session->apply(EditMesh{mesh, {}, {}, {}, {}, true});
  for (const Command& command : std::initializer_list<Command>{DeletePoint{stroke}, MovePoint{stroke, {0, 20, 0}},
                                                               ResizePoint{stroke, 2}, DeletePoint{mark}})
    EXPECT_NE(refusal(*session, command).find("locked"), std::string::npos);
}

TEST(Paint, OfADiscBetweenVoxelsChangesNothing) {
  const auto session = open_settled();
  const auto before = first_mesh(*session).field;
  AddPoint stroke = ball_of_paint(first_mesh(*session).id, {0.1, 0.1, 0.3}, 3);
  stroke.brush = PaintBrush::disc({0, 0, 1}, 0.01);
  session->apply(stroke);
  EXPECT_EQ(first_mesh(*session).field->box, before->box);
  EXPECT_EQ(first_mesh(*session).field->values, before->values);
}

TEST(Paint, InvalidStrokesAreRefused) {
  const auto session = open_settled();
  AddPoint stroke = ball_of_paint(first_mesh(*session).id, {0, 0, 0}, 0);
  EXPECT_NE(refusal(*session, stroke).find("radius"), std::string::npos);
  stroke.radius_mm = 2, stroke.kind = MarkKind::Boundary;
  EXPECT_NE(refusal(*session, stroke).find("boundary"), std::string::npos);
  stroke.kind = MarkKind::Inside, stroke.brush = PaintBrush::disc({0, 0, 2}, 1);
  EXPECT_NE(refusal(*session, stroke).find("unit normal"), std::string::npos);
  stroke.brush = PaintBrush::disc({0, 0, 1}, 0);
  EXPECT_NE(refusal(*session, stroke).find("thickness"), std::string::npos);
  stroke.brush = PaintBrush::ball(), stroke.radius_mm = 101;
  EXPECT_NE(refusal(*session, stroke).find("100 mm"), std::string::npos);
}

/// Cells of several voxels: cells that paint covers in part have the mean of paint and field.
TEST(Paint, OfLargerCellsIsAveraged) {
  VolumeGeometry volume;
  volume.size = {40, 40, 40};
  auto solved = std::make_shared<MeshField>();
  solved->cell = {2.5, 2.5, 2};
  solved->box = {{0, 0, 0}, cell_geometry(volume, solved->cell).size};
  solved->values.assign(solved->box.voxel_count(), 0);
  solved->marks = {{MarkKind::Inside, {0, 0, 0}, 1}};
  const auto field = painted_field(solved, {{true, {{20, 20, 20}}, 9.3}}, volume);
  double painted_mm3 = 0;
  for (const std::uint16_t value : field->values) painted_mm3 += value > 32768 ? 2.5 * 2.5 * 2 : 0;
  EXPECT_NEAR(painted_mm3, 4 * M_PI / 3 * std::pow(9.3, 3), 150);
  // Along a row through the centre, the interpolated surface is where the ball ends.
  const VolumeGeometry grid = field->grid(volume);
  const Eigen::Vector3d centre = grid.index_from_world() * Eigen::Vector3d(20, 20, 20);
  const int j = static_cast<int>(std::lround(centre.y())), k = static_cast<int>(std::lround(centre.z()));
  for (int i = static_cast<int>(centre.x()); i + 1 < grid.size[0]; ++i) {
    const double here = field->values[field->box.offset(i, j, k)], next = field->values[field->box.offset(i + 1, j, k)];
    if (!(here > 32767.5 && next < 32767.5)) continue;
    const double crossing = i + (here - 32767.5) / (here - next);
    const Eigen::Vector3d mm = grid.world_from_index() * Eigen::Vector3d(crossing, j, k);
    EXPECT_NEAR((mm - Eigen::Vector3d(20, 20, 20)).norm(), 9.3, 0.5);
  }
}

}  // namespace
}  // namespace simplexseg
