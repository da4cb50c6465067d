// SPDX-License-Identifier: Apache-2.0
// Local marks in a session: extent of their changes, also after an undo and in a scene that was opened.
#include <cmath>

#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Object mask of the field of the first mesh.
Mask object_of(const Session& session) { return first_mesh(session).field->object(ball_image().geometry()); }

/// Number of voxels farther than 12 mm from a place in which two objects differ.
int count_far_changes(const Mask& a, const Mask& b, const Eigen::Vector3d& place) {
  const VolumeGeometry& g = a.geometry;
  const Eigen::Affine3d world = g.world_from_index();
  int far = 0;
  std::size_t v = 0;
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i, ++v)
        far += a.voxels[v] != b.voxels[v] && (world * Eigen::Vector3d(i, j, k) - place).norm() > 12;
  return far;
}

/// Marks that make the object smaller and larger, all on one side.
void add_plain_marks(Session& session, int count) {
  for (int n = 0; n < count; ++n) {
    const double angle = 0.35 * n;
    session.apply(AddPoint{first_mesh(session).id,
                           {-14 * std::cos(angle), 14 * std::sin(angle), 2.0 * (n % 3)},
                           n % 2 ? MarkKind::Inside : MarkKind::Outside,
                           1.8});
    session.advance_steps(2);
  }
}

AddPoint local_mark(ItemId mesh) {
  AddPoint mark{mesh, {14.5, 0, 0}, MarkKind::Outside, 1.8};
  mark.local = true;
  return mark;
}

TEST(LocalMarks, ChangeNothingFarAwayAndTheirDeletionRestoresTheObject) {
  const auto session = open_with_field();
  session->advance_steps(20);
  add_plain_marks(*session, 3);
  const Mask before = object_of(*session);
  const AddPoint mark = local_mark(first_mesh(*session).id);
  const ItemId point = session->apply(mark);
  session->advance_steps(2);
  const Mask with_mark = object_of(*session);
  EXPECT_NE(with_mark.voxels, before.voxels);
  EXPECT_EQ(count_far_changes(before, with_mark, mark.position_mm), 0);
  session->apply(DeletePoint{point});
  session->advance_steps(2);
  EXPECT_EQ(object_of(*session).voxels, before.voxels);
}

TEST(LocalMarks, ChangeTheFieldThatASceneContains) {
  const auto live = open_with_field();
  live->advance_steps(20);
  add_plain_marks(*live, 10);
  const Mask before = object_of(*live);
  const auto reopened = open_session(2, live->scene());
  ASSERT_EQ(object_of(*reopened).voxels, before.voxels);
  const AddPoint mark = local_mark(first_mesh(*reopened).id);
  reopened->apply(mark);
  reopened->advance_steps(2);
  EXPECT_NE(object_of(*reopened).voxels, before.voxels);
  EXPECT_EQ(count_far_changes(before, object_of(*reopened), mark.position_mm), 0);
}

TEST(LocalMarks, ChangeTheFieldThatAnUndoRestored) {
  const auto session = open_with_field();
  session->advance_steps(20);
  add_plain_marks(*session, 5);
  for (int n = 0; n < 3; ++n) session->apply(Undo{});
  const Mask before = object_of(*session);
  const AddPoint mark = local_mark(first_mesh(*session).id);
  session->apply(mark);
  session->advance_steps(2);
  EXPECT_NE(object_of(*session).voxels, before.voxels);
  EXPECT_EQ(count_far_changes(before, object_of(*session), mark.position_mm), 0);
}

}  // namespace
}  // namespace simplexseg
