// SPDX-License-Identifier: Apache-2.0
// Meshes do not affect each other, and the engine uses the parameters of the scene.
#include "session/session.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Scene with a mesh that starts on its finest level; only its pose changes.
Scene settled_scene() {
  Scene scene = ball_scene();
  scene.simulation.final_vertices = 320;
  return scene;
}
const Positions& ball_of(const Session& session) { return session.scene().meshes[0].mesh.positions; }

TEST(Independence, OtherMeshesDoNotChangeTheResult) {
  const auto alone = open_session(1, settled_scene());
  alone->advance_steps(900);
  const Positions expected = ball_of(*alone);

  const auto added = open_session(1, settled_scene());
  added->advance_steps(60);
  added->apply(AddMesh{"other", {{3, 3, 3}, 6}, {}, 0});
  added->advance_steps(60);
  added->apply(RefineMesh{added->scene().meshes[1].id});
  added->advance_steps(780);
  EXPECT_LT(largest_distance(ball_of(*added), expected), 2e-3) << "another mesh was added, and refined";

  const auto renamed = open_session(1, settled_scene());
  renamed->advance_steps(60);
  renamed->apply(EditMesh{renamed->scene().meshes[0].id, "renamed", {}, {}, {}});
  renamed->apply(Undo{});
  renamed->advance_steps(840);
  EXPECT_LT(largest_distance(ball_of(*renamed), expected), 2e-3) << "it was renamed, and that was undone";
}

bool has_array(const Session& session, const std::string& name) {
  for (const Engine::AllocatedArray& array : session.engine().allocated_arrays())
    if (array.name == name) return true;
  return false;
}
bool plans(const Session& session, const std::string& array) {
  for (const StepPlan::Item& item : session.plan().items)
    if (item.name == array) return item.needed;
  return false;
}

TEST(Independence, OtherFinalVerticesReachTheEngine) {
  // Local intensities are used only on the finest level.
  Scene scene = ball_scene();
  set(scene.meshes[0].parameters, {"evidence", "local", 0.5f});
  const auto session = open_session(1, scene);
  session->advance_steps(5);
  EXPECT_FALSE(has_array(*session, "local statistics"));
  const int final_vertices = simulation_index("final_vertices");
  session->apply(SetSimulationParameter{final_vertices, 320});
  EXPECT_TRUE(has_array(*session, "local statistics"));
  EXPECT_TRUE(plans(*session, "local statistics"));
  session->advance_steps(5);
  Scene opened = session->scene();
  const auto fresh = open_session(1, opened);
  session->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.25f});
  fresh->apply(SetForceParameter{0, ForceId::Smoothing, 0, 0.25f});
  session->advance_steps(5), fresh->advance_steps(5);
  EXPECT_LT(largest_distance(ball_of(*session), ball_of(*fresh)), 1e-4);
  session->apply(SetSimulationParameter{final_vertices, 1280});
  EXPECT_FALSE(has_array(*session, "local statistics"));
  EXPECT_FALSE(plans(*session, "local statistics"));
  session->apply(Undo{});
  EXPECT_TRUE(has_array(*session, "local statistics"));
}

}  // namespace
}  // namespace simplexseg
