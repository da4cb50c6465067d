// SPDX-License-Identifier: Apache-2.0
// Undo history without a session: limits, names, and movements that form one unit.
#include "session/undo_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <span>

namespace simplexseg {
namespace {

Scene scene_of(int steps, std::size_t vertices = 0) {
  Scene scene;
  scene.steps = steps;  // distinguishes the scenes
  scene.meshes.emplace_back();
  scene.meshes[0].mesh.positions.resize(vertices);
  return scene;
}

TEST(UndoHistory, ExchangesScenes) {
  UndoHistory history;
  Scene scene = scene_of(0);
  EXPECT_FALSE(history.undo(scene));
  EXPECT_FALSE(history.redo(scene));
  history.push({scene, ResetPose{0}});
  scene.steps = 1;
  EXPECT_STREQ(history.undo_title(), "reset segmentation");
  EXPECT_TRUE(history.undo(scene));
  EXPECT_EQ(scene.steps, 0);
  EXPECT_STREQ(history.undo_title(), "");
  EXPECT_STREQ(history.redo_title(), "reset segmentation");
  EXPECT_TRUE(history.redo(scene));
  EXPECT_EQ(scene.steps, 1);
  history.undo(scene);
  history.clear_redo();
  EXPECT_FALSE(history.can_redo());
}

TEST(UndoHistory, KeepsTheLatestTwoHundred) {
  UndoHistory history;
  for (int n = 0; n < 250; ++n) history.push({scene_of(n), ResetPose{0}});
  Scene scene = scene_of(250);
  int undone = 0;
  while (history.undo(scene)) ++undone;
  EXPECT_EQ(undone, 200);
  EXPECT_EQ(scene.steps, 50);
}

TEST(UndoHistory, DiscardsTheOldestOfLargeScenes) {
  UndoHistory history(1'000'000);
  // Different positions each time, 12 bytes per vertex: 408 kB per scene.
  for (int n = 0; n < 6; ++n) {
    Scene large = scene_of(n, 34'000);
    large.meshes[0].mesh.positions[0].x() = static_cast<float>(n);
    history.push({std::move(large), ResetPose{0}});
  }
  Scene scene = scene_of(6);
  int undone = 0;
  while (history.undo(scene)) ++undone;
  EXPECT_EQ(undone, 3) << "the one that exceeds the limit is still kept";
  EXPECT_EQ(scene.steps, 3);
}

/// Mesh moved by `step`, about as far as a mesh moves between two corrections.
Scene moved(int step, int level) {
  Scene scene = scene_of(step);
  MeshItem& item = scene.meshes[0];
  item.id = 1;
  item.name = "kidney";
  item.mesh = make_sphere({100, -60, 40}, 30 + 0.01 * step, level);
  item.previous = make_sphere({100, -60, 40}, 30 + 0.01 * step - 0.003, level).positions;
  item.shape.assign(item.mesh.positions.size(), Vec4{1, 2, 3, static_cast<float>(level)});
  return scene;
}

bool same_bits(const Scene& a, const Scene& b) {
  const MeshItem &one = a.meshes[0], &other = b.meshes[0];
  const auto same = [](const auto& x, const auto& y) {
    return std::ranges::equal(std::as_bytes(std::span(x)), std::as_bytes(std::span(y)));
  };
  return a.steps == b.steps && same(one.mesh.positions, other.mesh.positions) && same(one.previous, other.previous) &&
         same(one.mesh.neighbours, other.mesh.neighbours) && same(one.shape, other.shape) &&
         same(one.profiles, other.profiles);
}

TEST(UndoHistory, TwoHundredStepsOf20kVerticesNeedAtMost100Megabytes) {
  UndoHistory history;
  std::vector<Scene> kept;
  constexpr int kSteps = 200, kLevel = 5;  // 20480 vertices
  for (int n = 0; n < kSteps; ++n) {
    history.push({moved(n, kLevel), MovePoint{1, {0, 0, 0}}});
    if (n % 50 == 7) kept.push_back(moved(n, kLevel));
  }
  EXPECT_LE(history.bytes(), 100'000'000u);
  RecordProperty("bytes", static_cast<int>(history.bytes()));
  Scene scene = moved(kSteps, kLevel);
  for (int n = kSteps - 1; n >= 0; --n) {
    ASSERT_TRUE(history.undo(scene));
    if (n % 50 == 7) {
      EXPECT_TRUE(same_bits(scene, kept[static_cast<std::size_t>(n / 50)])) << n;
    }
  }
  EXPECT_LE(history.bytes(), 110'000'000u) << "including undone actions";
  while (history.redo(scene)) {
  }
  EXPECT_TRUE(same_bits(scene, moved(kSteps, kLevel)));
}

TEST(UndoHistory, RestoresAllBits) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), tiny = std::numeric_limits<float>::denorm_min();
  Scene scene = moved(1, 0);
  MeshItem& item = scene.meshes[0];
  item.previous[0] = {nan, -0.0f, tiny};
  item.mesh.positions[0] = {0.0f, 0.0f, -tiny};
  item.profiles = {nan, 1};
  Scene fewer = scene;
  fewer.meshes[0].previous.resize(3);
  Scene none = scene;
  none.meshes[0].previous.clear();
  for (const Scene& one : {scene, fewer, none}) {
    UndoHistory history;
    history.push({one, ResetPose{1}});
    history.push({one, ResetPose{1}});  // all arrays shared
    Scene current = moved(9, 1);
    ASSERT_TRUE(history.undo(current));
    EXPECT_TRUE(same_bits(current, one));
    ASSERT_TRUE(history.undo(current));
    EXPECT_TRUE(same_bits(current, one));
  }
}

TEST(UndoHistory, NamesTheActions) {
  UndoHistory history;
  Scene scene = moved(0, 0);
  scene.points.push_back({7, 1, {0, 0, 0}, MarkKind::Inside});
  history.push({scene, AddPoint{1, {0, 0, 0}, MarkKind::Outside}});
  history.push({scene, MovePoint{7, {0, 0, 0}}});
  history.push({scene, SetForceParameter{0, ForceId::Smoothing, 0, 1}});
  history.push({scene, EditMesh{1, {}, {}, {}, {}, true}});
  using Names = std::vector<std::string>;
  EXPECT_EQ(history.undo_names(), (Names{"add outside point: kidney", "move inside point: kidney",
                                         "Smoothing, weight: kidney", "lock segmentation: kidney"}));
  history.undo(scene), history.undo(scene);
  EXPECT_EQ(history.redo_names(), (Names{"Smoothing, weight: kidney", "lock segmentation: kidney"}));
}

TEST(UndoHistory, OneMovementIsOneUnit) {
  const auto after = [](Command last) {
    UndoHistory history;
    history.push({{}, std::move(last)});
    return history;
  };
  const Command moves = MovePoint{1, {0, 0, 0}, true}, moved = MovePoint{1, {0, 0, 0}, false};
  EXPECT_FALSE(UndoHistory().continues(moves));
  EXPECT_TRUE(after(AddPoint{1, {0, 0, 0}}).continues(moves));
  EXPECT_TRUE(after(moved).continues(moves));
  EXPECT_FALSE(after(moved).continues(moved));
  EXPECT_FALSE(after(ResetPose{0}).continues(moves));
  EXPECT_FALSE(after(moved).continues(MovePoint{2, {0, 0, 0}, true})) << "another point";
  UndoHistory added;
  Scene before;
  before.points.push_back({1, 1, {0, 0, 0}});
  added.push({before, AddPoint{1, {0, 0, 0}}});
  EXPECT_FALSE(added.continues(moves)) << "the point existed before the one that was added";
  EXPECT_TRUE(added.continues(MovePoint{2, {0, 0, 0}, true})) << "the added point";
  const Command weight = SetForceParameter{1, ForceId::Evidence, 0, 1};
  EXPECT_TRUE(after(weight).continues(SetForceParameter{1, ForceId::Evidence, 0, 2, true}));
  EXPECT_FALSE(after(weight).continues(SetForceParameter{1, ForceId::Evidence, 0, 2})) << "another movement";
  EXPECT_FALSE(after(weight).continues(SetForceParameter{2, ForceId::Evidence, 0, 2, true}));
  EXPECT_FALSE(after(weight).continues(SetForceParameter{1, ForceId::Smoothing, 0, 2, true}));
  EXPECT_FALSE(after(weight).continues(SetForceParameter{1, ForceId::Evidence, 1, 2, true}));
  EXPECT_FALSE(after(weight).continues(SetSimulationParameter{0, 1, true}));
  EXPECT_TRUE(after(SetSimulationParameter{3, 1}).continues(SetSimulationParameter{3, 2, true}));
  EXPECT_FALSE(after(SetSimulationParameter{3, 1}).continues(SetSimulationParameter{3, 2}));
  EXPECT_FALSE(after(SetSimulationParameter{3, 1}).continues(SetSimulationParameter{4, 2, true}));
  EXPECT_FALSE(after(ResetPose{0}).continues(ResetPose{0}));
}

}  // namespace
}  // namespace simplexseg
