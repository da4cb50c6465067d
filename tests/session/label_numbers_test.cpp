// SPDX-License-Identifier: Apache-2.0
// Labels of names, and codes of meshes.
#include "core/error.h"
#include "session/free_attributes.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

const SegmentCode kSpleen{{"SCT", "123037004", "Anatomical Structure"}, {"SCT", "78961009", "Spleen"}, {}};

ItemId add_named(Session& session, const std::string& name) {
  return session.apply(AddMesh{name, {{3, 3, 3}, 8}, {}, 0});
}
const MeshItem& mesh_of(Session& session, ItemId id) { return *session.scene().find_mesh(id); }

TEST(LabelNumbers, APresetNumbersTheMeshesByName) {
  const auto session = open_session();  // "ball" with label 1
  const ItemId spleen = add_named(*session, "Spleen"), liver = add_named(*session, "Liver");
  EXPECT_EQ(mesh_of(*session, liver).label, 3);
  session->apply(ChooseLabelPreset{"abdomen", {{"Spleen", 1}, {"Left kidney", 3}, {"Liver", 6}}});
  EXPECT_EQ(mesh_of(*session, spleen).label, 1);
  EXPECT_EQ(mesh_of(*session, liver).label, 6);
  EXPECT_EQ(session->scene().find_mesh("ball")->label, 2) << "1 is the label of the spleen";
  const ItemId unnamed = add_named(*session, "");
  EXPECT_EQ(mesh_of(*session, unnamed).label, 4) << "3 is reserved for the left kidney";
  session->apply(EditMesh{unnamed, "Left kidney", {}, {}, {}});
  EXPECT_EQ(mesh_of(*session, unnamed).label, 3);
  session->apply(Undo{});
  EXPECT_EQ(mesh_of(*session, unnamed).label, 4);
  EXPECT_EQ(mesh_of(*session, unnamed).name, "mesh 1");
  session->apply(Undo{});
  session->apply(Undo{});
  EXPECT_TRUE(session->scene().labels.by_name.empty());
  EXPECT_EQ(mesh_of(*session, liver).label, 3);
  session->apply(Redo{});
  EXPECT_EQ(session->scene().labels.preset, "abdomen");
  EXPECT_EQ(mesh_of(*session, liver).label, 6);
}

TEST(LabelNumbers, ANameGetsItsLabelAgain) {
  const auto session = open_session();
  const ItemId lesion = add_named(*session, "Lesion");
  session->apply(EditMesh{lesion, {}, {}, {}, 40});
  session->apply(DeleteMesh{lesion});
  EXPECT_EQ(mesh_of(*session, add_named(*session, "other")).label, 2);
  EXPECT_EQ(mesh_of(*session, add_named(*session, "Lesion")).label, 40);
  // A label in use is not given twice.
  session->apply(EditMesh{session->scene().find_mesh("Lesion")->id, "renamed", {}, {}, {}});
  EXPECT_EQ(mesh_of(*session, add_named(*session, "Lesion")).label, 3);
}

TEST(LabelNumbers, InvalidOnesAreRefused) {
  const auto session = open_session();
  const std::size_t log = session->log().size();
  EXPECT_THROW(session->apply(ChooseLabelPreset{"x", {{"a", 1}, {"b", 1}}}), Error);
  EXPECT_THROW(session->apply(ChooseLabelPreset{"x", {{"a", 0}}}), Error);
  EXPECT_THROW(session->apply(ChooseLabelPreset{"x", {{"", 1}}}), Error);
  EXPECT_EQ(session->log().size(), log);
  EXPECT_EQ(session->scene().labels.preset, "");
}

TEST(SegmentCodes, StayWithARenamedMeshAndAreUndone) {
  const auto session = open_session();
  const ItemId ball = session->scene().meshes[0].id;
  const std::size_t undos = session->history().undo_names().size();
  EditMesh choice{ball, "Spleen", Colour{1, 2, 3}, {}, 7};
  choice.code = kSpleen;
  session->apply(choice);
  EXPECT_EQ(session->history().undo_names().size(), undos + 1) << "one unit of undo";
  session->apply(EditMesh{ball, "Spleen of the donor", {}, {}, {}});
  EXPECT_EQ(mesh_of(*session, ball).code, kSpleen);
  EXPECT_EQ(mesh_of(*session, session->apply(DuplicateMesh{ball})).code, kSpleen);
  session->apply(Undo{});
  session->apply(Undo{});
  session->apply(Undo{});
  EXPECT_TRUE(mesh_of(*session, ball).code.empty());
  EXPECT_EQ(mesh_of(*session, ball).name, "ball");
  EXPECT_EQ(mesh_of(*session, ball).label, 1);
  SegmentCode invalid = kSpleen;
  invalid.type.meaning = "a|b";
  choice.code = invalid;
  EXPECT_THROW(session->apply(choice), Error);
}

TEST(LabelNumbers, AReplayGivesTheSameLabelsAndCodes) {
  const auto session = open_session();
  session->apply(ChooseLabelPreset{"abdomen", {{"Spleen", 1}, {"Liver", 6}}});
  const ItemId mesh = add_named(*session, "");
  EditMesh choice{mesh, "Liver", {}, {}, {}};
  choice.code = kSpleen;
  session->apply(choice);
  session->apply(DeleteMesh{session->scene().find_mesh("ball")->id});
  add_named(*session, "ball");
  const auto again = open_session();
  again->replay(session->log(), session->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*session), state_of(*again)));
  ASSERT_EQ(again->scene().meshes.size(), 2u);
  for (std::size_t m = 0; m < 2; ++m) {
    EXPECT_EQ(again->scene().meshes[m].code, session->scene().meshes[m].code);
    EXPECT_EQ(again->scene().meshes[m].label, session->scene().meshes[m].label);
  }
  EXPECT_EQ(again->scene().labels.by_name, session->scene().labels.by_name);
}

}  // namespace
}  // namespace simplexseg
