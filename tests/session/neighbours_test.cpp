// SPDX-License-Identifier: Apache-2.0
// Neighbouring meshes with fields: inside marks of one are background for the other.
#include "image/metrics.h"
#include "image/rasterise.h"
#include "session/label_map.h"
#include "session/mesh_marks.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kLeft(-9, 0, 0), kRight(9, 0, 0);
constexpr double kRadius = 10;  // the balls touch and have the same intensity

double depth(const Eigen::Vector3d& mm) { return kRadius - std::min((mm - kLeft).norm(), (mm - kRight).norm()); }

Volume touching_balls() {
  const Volume& like = phantom("flat").image;
  Volume image(like.geometry(), VoxelType::Float32);
  const auto [ni, nj, nk] = like.geometry().size;
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i)
        image.voxels<float>()[image.offset(i, j, k)] =
            (depth(like.geometry().world_from_index() * Eigen::Vector3d(i, j, k)) > 0 ? 150.0f : 50.0f) +
            static_cast<float>((i * 7 + j * 13 + k * 5) % 11);
  return image;
}
/// Half of the two balls on one side of the plane between them.
Mask half(const Volume& image, bool right) {
  Mask mask{image.geometry(), std::vector<std::uint8_t>(image.geometry().voxel_count())};
  const auto [ni, nj, nk] = image.geometry().size;
  for (int k = 0; k < nk; ++k)
    for (int j = 0; j < nj; ++j)
      for (int i = 0; i < ni; ++i) {
        const Eigen::Vector3d mm = image.geometry().world_from_index() * Eigen::Vector3d(i, j, k);
        mask.voxels[image.offset(i, j, k)] = depth(mm) > 0 && (mm[0] > 0) == right;
      }
  return mask;
}

std::unique_ptr<Session> open_on(const Volume& image) {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  auto session = std::make_unique<Session>(make_cpu_engine(2), nullptr, 2);
  session->open(scene, image);
  session->apply(AddMesh{"left", {kLeft, 9}, std::nullopt});
  return session;
}
Mask mask_of(const Session& session, int mesh) {
  return rasterise(session.scene().meshes[mesh].mesh, session.volume().geometry());
}

TEST(Neighbours, TouchingBallsOfOneIntensityAreSeparated) {
  const Volume image = touching_balls();
  const auto session = open_on(image);
  session->advance_steps(2000, true);
  const double alone = dice(half(image, false), mask_of(*session, 0));
  const ItemId right = session->apply(AddMesh{"right", {kRight, 9}, std::nullopt});
  session->apply(EditMesh{right, std::nullopt, std::nullopt, std::nullopt, 2});
  session->advance_steps(3000, true);
  const double left = dice(half(image, false), mask_of(*session, 0));
  EXPECT_GT(left, 0.88);
  EXPECT_GT(left, alone + 0.2) << "alone it contains more of the other ball";
  EXPECT_GT(dice(half(image, true), mask_of(*session, 1)), 0.88);
  const LabelMap map = make_label_map(session->scene(), image.geometry());
  const Mask left_mask = half(image, false);
  std::size_t shared = 0, wrong = 0, all = 0;
  for (std::size_t v = 0; v < left_mask.voxels.size(); ++v) {
    const int label = map.labels.voxels<std::uint8_t>()[v];
    all += label != 0;
    wrong += (label == 1) != (left_mask.voxels[v] != 0);
  }
  shared = map.shared_voxels;
  EXPECT_LT(shared, all / 50) << "the meshes hardly overlap";
  EXPECT_LT(wrong, all / 8);
}

TEST(Neighbours, AFieldIsStaleWhenANeighbourIsMarkedWithinItsBox) {
  const Volume image = touching_balls();
  const auto session = open_on(image);
  session->advance_steps(10);
  const auto& meshes = session->scene().meshes;
  const auto stale = [&] { return has_stale_field(session->scene(), session->scene().meshes[0], image); };
  EXPECT_FALSE(stale());
  EXPECT_TRUE(meshes[0].field->others.empty());
  const ItemId right = session->apply(AddMesh{"right", {kRight, 3}, std::nullopt});
  EXPECT_TRUE(stale());
  session->advance_steps(10);
  EXPECT_FALSE(stale());
  ASSERT_EQ(session->scene().meshes[0].field->others.size(), 1u);
  EXPECT_EQ(session->scene().meshes[0].field->others[0].position_mm, kRight);
  session->apply(AddPoint{right, {9, 3, 0}, MarkKind::Outside, 2});
  EXPECT_FALSE(stale()) << "outside marks of others do not matter";
  session->apply(Undo{});
  session->apply(DeleteMesh{right});
  EXPECT_TRUE(stale());
  const MeshField box = [] {
    MeshField field;
    field.box.first = {0, 0, 0}, field.box.size = {10, 10, 10}, field.values.resize(1000);
    return field;
  }();
  const Eigen::Vector3d near = image.geometry().world_from_index() * Eigen::Vector3d(12, 5, 5),
                        far = image.geometry().world_from_index() * Eigen::Vector3d(30, 5, 5);
  EXPECT_EQ(within_reach({{MarkKind::Inside, near, 4}, {MarkKind::Inside, far, 4}}, box, image.geometry()).size(), 1u);
}

TEST(Neighbours, AReplayEndsInTheSameBits) {
  const Volume image = touching_balls();
  const auto live = open_on(image);
  live->advance_steps(60);
  const ItemId right = live->apply(AddMesh{"right", {kRight, 7}, std::nullopt});
  live->advance_steps(60);
  live->apply(AddPoint{right, {2, 0, 0}, MarkKind::Inside, 1.5});
  live->advance_steps(60);
  live->apply(Undo{});
  live->advance_steps(30);
  Scene scene;
  scene.simulation = default_simulation_parameters();
  Session again(make_cpu_engine(1), nullptr, 1);
  again.open(scene, image);
  again.replay(live->log(), live->steps_since_last_command());
  for (int m : {0, 1}) {
    EXPECT_TRUE(same_bits(again.scene().meshes[m].mesh.positions, live->scene().meshes[m].mesh.positions));
    EXPECT_EQ(again.scene().meshes[m].field->values, live->scene().meshes[m].field->values);
  }
}

}  // namespace
}  // namespace simplexseg
