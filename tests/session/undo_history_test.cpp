// SPDX-License-Identifier: Apache-2.0
// The history by itself: what it keeps, what it forgets, and what one movement of the hand is.
#include "session/undo_history.h"

#include <gtest/gtest.h>

namespace simplexseg {
namespace {

Scene scene_of(int steps, std::size_t vertices = 0) {
  Scene scene;
  scene.steps = steps;  // tells the scenes apart
  scene.meshes.emplace_back();
  scene.meshes[0].mesh.positions.resize(vertices);
  return scene;
}

TEST(UndoHistory, ExchangesScenes) {
  UndoHistory history;
  Scene scene = scene_of(0);
  EXPECT_FALSE(history.undo(scene));
  EXPECT_FALSE(history.redo(scene));
  history.keep({scene, ResetPose{0}});
  scene.steps = 1;
  EXPECT_STREQ(history.undo_title(), "reset pose");
  EXPECT_TRUE(history.undo(scene));
  EXPECT_EQ(scene.steps, 0);
  EXPECT_STREQ(history.undo_title(), "");
  EXPECT_STREQ(history.redo_title(), "reset pose");
  EXPECT_TRUE(history.redo(scene));
  EXPECT_EQ(scene.steps, 1);
  history.undo(scene);
  history.forget_undone();
  EXPECT_FALSE(history.can_redo());
}

TEST(UndoHistory, KeepsTheLatestTwoHundred) {
  UndoHistory history;
  for (int n = 0; n < 250; ++n) history.keep({scene_of(n), ResetPose{0}});
  Scene scene = scene_of(250);
  int undone = 0;
  while (history.undo(scene)) ++undone;
  EXPECT_EQ(undone, 200);
  EXPECT_EQ(scene.steps, 50);
}

TEST(UndoHistory, ForgetsTheOldestOfLargeScenes) {
  UndoHistory history;
  // 24 bytes of pose, 12 of neighbours and 16 of shape reference a vertex: 520 MB a scene.
  for (int n = 0; n < 6; ++n) history.keep({scene_of(n, 10'000'000), ResetPose{0}});
  Scene scene = scene_of(6);
  int undone = 0;
  while (history.undo(scene)) ++undone;
  EXPECT_EQ(undone, 3) << "the one that exceeds 1 GiB is the last that is kept";
  EXPECT_EQ(scene.steps, 3);
}

TEST(UndoHistory, AMovementOfTheHandIsOneUnit) {
  const auto after = [](Command last) {
    UndoHistory history;
    history.keep({{}, std::move(last)});
    return history;
  };
  const Command moves = MovePoint{1, {0, 0, 0}, true}, moved = MovePoint{1, {0, 0, 0}, false};
  EXPECT_FALSE(UndoHistory().continues(moves));
  EXPECT_TRUE(after(AddPoint{1, {0, 0, 0}}).continues(moves));
  EXPECT_TRUE(after(moved).continues(moves));
  EXPECT_FALSE(after(moved).continues(moved));
  EXPECT_FALSE(after(ResetPose{0}).continues(moves));
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
