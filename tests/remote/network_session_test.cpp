// SPDX-License-Identifier: Apache-2.0
// A session that starts from a network on a stand-in server, continues without the server, and is replayed.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "image/label_surface.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "io/scene/log_io.h"
#include "io/scene/mesh_start.h"
#include "io/scene/scene_io.h"
#include "remote/network_calls.h"
#include "session/session_fixture.h"
#include "stand_in_process.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

/// Scene with one mesh in the ball of the phantom, whose field is solved.
std::unique_ptr<Session> session_in_ball() { return open_with_field(); }

SetStart start_by(const test::StandInProcess& process, const Session& session) {
  const MeshItem& item = first_mesh(session);
  const NetworkRequest request{session.volume(), prompts_of(session.scene(), item, session.volume().geometry()), ""};
  return {item.id, start_of_network(segment_by_network(process.server(), request, [] {}), 2).start};
}

TEST(NetworkSession, GoesOnAndIsReplayedWithoutTheServer) {
  if (!test::has_blosc()) GTEST_SKIP() << "install python3-blosc";
  test::StandInProcess process("nninteractive");
  const std::unique_ptr<Session> live = session_in_ball();
  live->advance_steps(20);
  const SetStart start = start_by(process, *live);
  process.end();
  live->apply(start);
  const ItemId mesh = first_mesh(*live).id;
  EXPECT_FALSE(first_mesh(*live).has_field());
  EXPECT_EQ(first_mesh(*live).mesh.positions, start.start->mesh->positions);
  // The prior is part of the field, which is solved from the image: the mask is not the result.
  live->advance_steps(30);
  ASSERT_TRUE(first_mesh(*live).has_field());
  EXPECT_EQ(first_mesh(*live).field->model, first_mesh(*live).prior_identity());
  EXPECT_GT(first_mesh(*live).field->model_trust, 0);
  EXPECT_NE(first_mesh(*live).mesh.positions, start.start->mesh->positions);
  live->apply(AddPoint{mesh, first_mesh(*live).seed.centre_mm, MarkKind::Inside});
  live->advance_steps(20);
  live->apply(Undo{}), live->apply(Undo{});
  EXPECT_FALSE(first_mesh(*live).start);
  live->apply(Redo{});
  live->advance_steps(10);

  const fs::path log = fs::path(::testing::TempDir()) / "network-log.json";
  write_log(log, live->log(), live->steps_since_last_command(), "");
  const LogFile read = read_log(log);
  const std::unique_ptr<Session> replayed = session_in_ball();
  replayed->replay(read.log, read.trailing_steps);
  EXPECT_TRUE(same_state(state_of(*live), state_of(*replayed)));
  fs::remove(log);
}

TEST(NetworkSession, ASceneKeepsTheMaskAndItsOrigin) {
  if (!test::has_blosc()) GTEST_SKIP() << "install python3-blosc";
  test::StandInProcess process("nninteractive");
  const std::unique_ptr<Session> live = session_in_ball();
  live->apply(start_by(process, *live));
  const fs::path file = fs::path(::testing::TempDir()) / "network-scene.json";
  write_scene(file, live->scene());
  const Scene again = read_scene(file, SceneVolume::Skip).scene;
  ASSERT_TRUE(again.meshes[0].start && again.meshes[0].start->network);
  const NetworkMask &before = *first_mesh(*live).start->network, &after = *again.meshes[0].start->network;
  EXPECT_EQ(after.identity, before.identity);
  EXPECT_EQ(after.server, before.server);
  EXPECT_EQ(after.network, "nnInteractive");
  EXPECT_EQ(after.licence, "CC BY-NC-SA 4.0 for tests");
  EXPECT_EQ(again.meshes[0].start->error_mm, 2);
  EXPECT_EQ(again.meshes[0].start->mesh->positions, first_mesh(*live).start->mesh->positions);
}

TEST(NetworkSession, ACancelledCallEnds) {
  if (!test::has_blosc()) GTEST_SKIP() << "install python3-blosc";
  struct Stop {};
  test::StandInProcess process("nninteractive");
  const NetworkServer server = process.server();
  EXPECT_THROW(network_info(server, [] { throw Stop(); }), Stop);
}

TEST(NetworkStart, IsRefusedWithoutAMaskOrWithAModel) {
  const std::unique_ptr<Session> session = session_in_ball();
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_NE(refusal(*session, SetStart{mesh, MeshStart{}}).find("it was not read"), std::string::npos);
  auto mask = std::make_shared<NetworkMask>();
  mask->voxels.box = session->volume().geometry();
  mask->voxels.voxels.assign(mask->voxels.box.voxel_count(), VoxelPaint::None);
  EXPECT_THROW(start_of_network(mask, 2), Error);
  mask->voxels.voxels[mask->voxels.voxels.size() / 2] = VoxelPaint::Inside;
  MeshStart start = start_of_network(mask, 2).start;
  start.error_mm = 0;
  EXPECT_NE(refusal(*session, SetStart{mesh, start}).find("out of range"), std::string::npos);
  session->apply(EditMesh{mesh, {}, {}, {}, {}, true});
  start.error_mm = 2;
  EXPECT_NE(refusal(*session, SetStart{mesh, start}).find("locked"), std::string::npos);
}

TEST(NetworkPromptsTest, AreVoxelsOfTheImage) {
  Scene scene;
  VolumeGeometry grid;
  grid.size = {10, 20, 30}, grid.spacing_mm = {2, 1, 3}, grid.origin_mm = {5, 5, 5};
  grid.direction << -1, 0, 0, 0, 0, 1, 0, 1, 0;
  const auto world = [&](double i, double j, double k) {
    return Eigen::Vector3d(grid.world_from_index() * Eigen::Vector3d(i, j, k));
  };
  MeshItem item;
  item.id = 1, item.seed.centre_mm = world(3, 4, 5);
  const auto add = [&](MarkKind kind, const Eigen::Vector3d& at, std::vector<Eigen::Vector3d> path = {}) {
    UserPoint point{0, 1, at, kind};
    point.path_mm = std::move(path);
    scene.points.push_back(point);
  };
  add(MarkKind::Outside, world(9, 19, 29.3));
  add(MarkKind::Boundary, world(1, 1, 1));
  add(MarkKind::Inside, world(100, 1, 1));  // outside the image
  add(MarkKind::Inside, world(2, 2, 2), {world(2, 6, 2) - world(2, 2, 2)});
  scene.points.push_back({0, 2, world(0, 0, 0), MarkKind::Inside});  // of another mesh
  const NetworkPrompts prompts = prompts_of(scene, item, grid);
  EXPECT_EQ(prompts.inside, (std::vector<VoxelIndex>{{3, 4, 5}, {2, 2, 2}, {2, 6, 2}}));
  EXPECT_EQ(prompts.outside, (std::vector<VoxelIndex>{{9, 19, 29}}));
  EXPECT_EQ(text_of(prompts), "4 points");
  item.seed.centre_mm = world(-5, 0, 0);
  EXPECT_THROW(prompts_of(scene, item, grid), Error);
}

TEST(NetworkPromptsTest, StrokesAreScribblesWithoutGaps) {
  Scene scene;
  VolumeGeometry grid;
  grid.size = {10, 20, 30}, grid.spacing_mm = {2, 1, 3}, grid.origin_mm = {5, 5, 5};
  const auto world = [&](double i, double j, double k) {
    return Eigen::Vector3d(grid.world_from_index() * Eigen::Vector3d(i, j, k));
  };
  MeshItem item;
  item.id = 1, item.seed.centre_mm = world(3, 4, 5);
  const auto add = [&](MarkKind kind, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    UserPoint point{0, 1, from, kind};
    if (to != from) point.path_mm = {to - from};
    scene.points.push_back(point);
  };
  add(MarkKind::Inside, world(2, 2, 2), world(2, 6, 2));
  add(MarkKind::Outside, world(5, 5, 5), world(8, 5, 20));  // across slices that are thicker than the scribble
  add(MarkKind::Outside, world(9, 9, 9), world(9, 9, 9));
  add(MarkKind::Inside, world(50, 1, 1), world(60, 1, 1));  // outside the image
  const NetworkPrompts prompts = prompts_of(scene, item, grid, 2);
  EXPECT_EQ(prompts.inside, (std::vector<VoxelIndex>{{3, 4, 5}}));
  EXPECT_EQ(prompts.outside, (std::vector<VoxelIndex>{{9, 9, 9}}));
  ASSERT_EQ(prompts.scribbles.size(), 2u);
  EXPECT_EQ(text_of(prompts), "2 points and 2 scribbles");
  std::vector<std::vector<VoxelIndex>> voxels(2);
  for (std::size_t n = 0; n < 2; ++n)
    prompts.scribbles[n].voxels.for_each([&](int i, int j, int k, bool) { voxels[n].push_back({i, j, k}); });
  EXPECT_TRUE(prompts.scribbles[0].inside && !prompts.scribbles[1].inside);
  for (int j = 2; j <= 6; ++j) EXPECT_TRUE(std::ranges::count(voxels[0], VoxelIndex{2, j, 2})) << j;
  for (const VoxelIndex& at : voxels[0]) EXPECT_TRUE(at[0] == 2 && at[2] == 2 && at[1] >= 1 && at[1] <= 7);
  for (int k = 5; k <= 20; ++k)
    EXPECT_TRUE(std::ranges::any_of(voxels[1], [&](const VoxelIndex& at) { return at[2] == k; })) << k;
  // A part of the mask that only a scribble marks belongs to the object.
  Mask mask{grid, std::vector<std::uint8_t>(grid.voxel_count())};
  const auto set = [&](int i, int j, int k) { mask.voxels[static_cast<std::size_t>((k * 20 + j) * 10 + i)] = 1; };
  set(3, 4, 5), set(2, 4, 2), set(7, 5, 15);
  EXPECT_EQ(std::ranges::count(object_at_prompts(mask, prompts).voxels, VoxelPaint::Inside), 2);
}

TEST(NetworkPromptsTest, ThePartsAtThePromptsAreKept) {
  VolumeGeometry grid;
  grid.size = {12, 5, 4};
  Mask mask{grid, std::vector<std::uint8_t>(240)};
  const auto set = [&](int i, int j, int k) { mask.voxels[static_cast<std::size_t>((k * 5 + j) * 12 + i)] = 1; };
  set(1, 1, 1), set(2, 1, 1), set(6, 1, 1), set(10, 3, 2);
  const PaintVoxels object = object_at_prompts(mask, {{{1, 1, 1}, {10, 3, 2}}, {}});
  EXPECT_EQ(object.box.size, (std::array<int, 3>{10, 3, 2}));
  EXPECT_EQ(std::ranges::count(object.voxels, VoxelPaint::Inside), 3);
  EXPECT_THROW(object_at_prompts(mask, {{{4, 4, 3}}, {}}), Error);
  EXPECT_THROW(object_at_prompts(Mask{grid, std::vector<std::uint8_t>(240)}, {{{1, 1, 1}}, {}}), Error);
}

}  // namespace
}  // namespace simplexseg
