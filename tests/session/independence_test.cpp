// SPDX-License-Identifier: Apache-2.0
// A mesh is simulated as if it were alone.
#include "session/session.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// On its finest level from the start: nothing of it changes but its pose.
Scene settled_scene() {
  Scene scene = ball_scene();
  scene.simulation.final_vertices = 320;
  return scene;
}
const Positions& ball_of(const Session& session) { return session.scene().meshes[0].mesh.positions; }

TEST(Independence, AMeshEndsWhereItEndsWhateverBecomesOfOthers) {
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

}  // namespace
}  // namespace simplexseg
