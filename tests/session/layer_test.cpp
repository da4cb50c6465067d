// SPDX-License-Identifier: Apache-2.0
// Layers in a session: commands, undo, replay, refusal, and no effect on the simulation.
#include <limits>

#include "session_fixture.h"

namespace simplexseg {
namespace {

LayerItem pet() {
  LayerItem item;
  item.name = "PET", item.path = "/nowhere/pet.nii.gz", item.unit = "SUV", item.scale = 1.0 / 3;
  item.window = 10, item.level = 5;
  return item;
}
LayerTransform shifted(double mm) {
  LayerTransform transform;
  transform.affine.translation().x() = mm;
  return transform;
}
EditLayer move_of(ItemId layer, double mm) {
  EditLayer edit{layer};
  edit.transform = shifted(mm);
  return edit;
}
EditLayer opacity_of(ItemId layer, float opacity, bool continues) {
  EditLayer edit{layer};
  edit.opacity = opacity, edit.continues = continues;
  return edit;
}

TEST(Layers, AreAddedEditedAndRemovedWithUndo) {
  const auto session = open_session();
  const ItemId id = session->apply(AddLayer{pet()});
  ASSERT_NE(id, 0u);
  LayerItem expected = pet();
  expected.id = id;
  ASSERT_NE(session->scene().find_layer(id), nullptr);
  EXPECT_EQ(*session->scene().find_layer(id), expected);
  EditLayer edit{id};
  edit.name = "FDG", edit.colour_map = ColourMap::Hot, edit.window = 4, edit.level = 2, edit.visible = false;
  session->apply(edit);
  session->apply(move_of(id, 1.0 / 3));
  const SessionState moved = state_of(*session);
  const LayerItem& now = *session->scene().find_layer(id);
  EXPECT_TRUE(now.name == "FDG" && now.colour_map == ColourMap::Hot && now.window == 4 && now.level == 2);
  EXPECT_FALSE(now.visible);
  EXPECT_EQ(now.transform, shifted(1.0 / 3));
  session->apply(RemoveLayer{id});
  EXPECT_TRUE(session->scene().layers.empty());
  EXPECT_EQ(session->history().undo_names().back(), "remove layer: FDG");
  session->apply(Undo{});
  EXPECT_TRUE(same_state(state_of(*session), moved));
  session->apply(Undo{});
  EXPECT_TRUE(session->scene().find_layer(id)->transform.is_identity());
  session->apply(Undo{});
  EXPECT_EQ(*session->scene().find_layer(id), expected);
  session->apply(Undo{});
  EXPECT_TRUE(session->scene().layers.empty());
  while (session->can_redo()) session->apply(Redo{});
  EXPECT_TRUE(session->scene().layers.empty());
}

TEST(Layers, ADragOfTheOpacityIsUndoneTogether) {
  const auto session = open_session();
  const ItemId id = session->apply(AddLayer{pet()});
  for (int k = 1; k <= 4; ++k) session->apply(opacity_of(id, 0.2f * static_cast<float>(k), k > 1));
  EditLayer window{id};
  window.window = 7, window.continues = true;  // another slider is another action
  session->apply(window);
  EXPECT_EQ(session->history().undo_names().size(), 3u);
  session->apply(Undo{});
  EXPECT_EQ(session->scene().find_layer(id)->opacity, 0.8f);
  session->apply(Undo{});
  EXPECT_EQ(session->scene().find_layer(id)->opacity, 0.5f);
}

TEST(Layers, AReplayRestoresThem) {
  const auto live = open_session(), replayed = open_session();
  live->advance_steps(5);
  const ItemId id = live->apply(AddLayer{pet()});
  live->advance_steps(5);
  for (int k = 1; k <= 3; ++k) live->apply(opacity_of(id, 0.3f * static_cast<float>(k), k > 1));
  live->apply(AddLayer{pet()});
  live->apply(move_of(id, 1e-7));
  live->apply(RemoveLayer{id});
  live->apply(Undo{});
  live->advance_steps(10);
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_EQ(replayed->scene().layers.size(), 2u);
  EXPECT_TRUE(same_state(state_of(*replayed), state_of(*live)));
}

TEST(Layers, DoNotAffectTheSimulation) {
  const auto layered = open_session(), plain = open_session();
  layered->advance_steps(5);
  const ItemId id = layered->apply(AddLayer{pet()});
  layered->advance_steps(5);
  layered->apply(move_of(id, 5));
  layered->advance_steps(10);
  plain->advance_steps(20);
  SessionState a = state_of(*layered);
  EXPECT_EQ(a.scene.layers.size(), 1u);
  a.scene.layers.clear();
  EXPECT_TRUE(same_state(a, state_of(*plain)));
}

TEST(Layers, RefuseWhatTheyCannotShow) {
  const auto session = open_session();
  const ItemId id = session->apply(AddLayer{pet()});
  EXPECT_NE(refusal(*session, RemoveLayer{id + 100}).find("no such layer"), std::string::npos);
  EXPECT_NE(refusal(*session, opacity_of(id, 1.5f, false)).find("opacity"), std::string::npos);
  EXPECT_NE(refusal(*session, opacity_of(id, std::nanf(""), false)).find("opacity"), std::string::npos);
  EditLayer edit{id};
  edit.window = 0;
  EXPECT_NE(refusal(*session, edit).find("window"), std::string::npos);
  edit = {id};
  edit.transform = LayerTransform{};
  edit.transform->affine.linear().setZero();
  EXPECT_NE(refusal(*session, edit).find("invertible"), std::string::npos);
  edit = move_of(id, std::numeric_limits<double>::infinity());
  EXPECT_NE(refusal(*session, edit).find("invertible"), std::string::npos);
  LayerItem without_name = pet(), without_file = pet();
  without_name.name.clear(), without_file.path.clear();
  EXPECT_NE(refusal(*session, AddLayer{without_name}).find("name"), std::string::npos);
  EXPECT_NE(refusal(*session, AddLayer{without_file}).find("file"), std::string::npos);
}

TEST(Layers, ColourMapsAreFoundByTheirNames) {
  for (const ColourMapInfo& info : colour_maps()) {
    EXPECT_EQ(find_colour_map(info.name), info.map);
    EXPECT_EQ(info_of(info.map).name, info.name);
  }
  EXPECT_EQ(find_colour_map("blue"), std::nullopt);
}

}  // namespace
}  // namespace simplexseg
