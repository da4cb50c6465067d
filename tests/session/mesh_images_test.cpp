// SPDX-License-Identifier: Apache-2.0
// Meshes whose fields are solved in layers: commands, undo, replay, sharing of images, and failures.
#include <cmath>

#include "image/metrics.h"
#include "image/rasterise.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Volume on the grid of ball_image() in which no object can be seen.
Volume image_without_object() {
  Volume image(ball_image().geometry(), VoxelType::Float32);
  std::uint32_t state = 1;
  for (float& value : image.voxels<float>()) {
    state = state * 1664525u + 1013904223u;
    value = static_cast<float>(state >> 24) / 16;
  }
  return image;
}

LayerItem layer_named(const char* name) {
  LayerItem item;
  item.name = name, item.path = std::string("/nowhere/") + name;
  return item;
}

/// Session on image_without_object() with the layers "ball", in which the object can be seen, and "other".
struct LayeredSession {
  std::unique_ptr<Session> session = open_session(2);
  int resampled = 0;
  ItemId ball = 0, other = 0, mesh = 0;

  LayeredSession() {
    session->open(scene(), image_without_object());
    session->set_layer_source([this](const LayerItem& layer, const VolumeGeometry& grid) {
      ++resampled;
      if (layer.name == "lost") throw Error("layer 'lost'", "its file is missing", "bring it back");
      EXPECT_TRUE(grid.same_grid(ball_image().geometry()));
      return layer.name == "ball" ? ball_image() : image_without_object();
    });
    mesh = first_mesh(*session).id;
    ball = session->apply(AddLayer{layer_named("ball")});
    other = session->apply(AddLayer{layer_named("other")});
  }
  static Scene scene() {
    static const Scene one = open_with_field()->scene();
    return one;
  }
  /// Dice of the object of the field with the ball.
  double agreement() {
    session->advance_steps(1);
    const MeshItem& item = first_mesh(*session);
    Mask truth{ball_image().geometry(), std::vector<std::uint8_t>(ball_image().geometry().voxel_count())};
    const Eigen::Affine3d world = truth.geometry.world_from_index();
    for (int k = 0; k < truth.geometry.size[2]; ++k)
      for (int j = 0; j < truth.geometry.size[1]; ++j)
        for (int i = 0; i < truth.geometry.size[0]; ++i)
          truth.voxels[ball_image().offset(i, j, k)] = (world * Eigen::Vector3d(i, j, k)).norm() <= kPhantomRadius;
    return item.has_field() ? dice(truth, item.field->object(truth.geometry)) : 0;
  }
};

TEST(MeshImages, TheMainImageDecidesWhereEdgesAre) {
  LayeredSession s;
  const double on_volume = s.agreement();
  EXPECT_LT(on_volume, 0.8);
  s.session->apply(SetImages{s.mesh, {s.ball, {}}});
  EXPECT_GT(s.agreement(), 0.95);
  EXPECT_EQ(s.session->history().undo_names().back(), "choose images of segmentation: ball");
  s.session->apply(Undo{});
  EXPECT_EQ(s.agreement(), on_volume);
}

TEST(MeshImages, AFurtherImageInformsThePrior) {
  LayeredSession s;
  const double alone = s.agreement();
  s.session->apply(SetImages{s.mesh, {0, {s.ball}}});
  EXPECT_GT(s.agreement(), alone + 0.02);
}

TEST(MeshImages, AreSharedByMeshesAndSolvedAgainAfterAChangeOfTheTransform) {
  LayeredSession s;
  const ItemId second = s.session->apply(AddMesh{"second", {{-8, 0, 0}, 6}, std::nullopt});
  s.session->apply(SetImages{s.mesh, {s.ball, {}}});
  s.session->apply(SetImages{second, {s.ball, {0}}});
  s.session->advance_steps(1);
  EXPECT_EQ(s.resampled, 1);
  const std::shared_ptr<const MeshField> before = first_mesh(*s.session).field;
  EditLayer edit{s.ball};
  edit.opacity = 0.2f;
  s.session->apply(edit);
  s.session->advance_steps(1);
  EXPECT_EQ(first_mesh(*s.session).field, before);
  edit = {s.ball};
  edit.transform = LayerTransform{};
  edit.transform->affine.translation().x() = 1;
  s.session->apply(edit);
  s.session->advance_steps(1);
  EXPECT_NE(first_mesh(*s.session).field, before);
  EXPECT_EQ(s.resampled, 2);
}

TEST(MeshImages, AReplayEndsInTheSameBits) {
  LayeredSession live;
  const auto commands_before = live.session->log().size();
  live.session->apply(SetImages{live.mesh, {live.ball, {0, live.other}}});
  live.session->advance_steps(3);
  EXPECT_GT(live.session->log().size(), commands_before + 1);
  const auto copy = open_session(2);
  copy->open(LayeredSession::scene(), image_without_object());
  copy->set_layer_source([](const LayerItem& layer, const VolumeGeometry&) {
    return layer.name == "ball" ? ball_image() : image_without_object();
  });
  copy->replay(live.session->log(), live.session->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*copy), state_of(*live.session)));
}

TEST(MeshImages, RefuseWhatIsNotThere) {
  LayeredSession s;
  EXPECT_NE(refusal(*s.session, SetImages{s.mesh, {s.ball + 100, {}}}).find("no layer"), std::string::npos);
  EXPECT_NE(refusal(*s.session, SetImages{s.mesh, {s.ball, {s.ball}}}).find("twice"), std::string::npos);
  s.session->apply(SetImages{s.mesh, {0, {s.ball}}});
  EXPECT_NE(refusal(*s.session, RemoveLayer{s.ball}).find("computed with it"), std::string::npos);
  s.session->apply(SetImages{s.mesh, {}});
  s.session->apply(RemoveLayer{s.ball});
  EXPECT_EQ(s.session->scene().layers.size(), 1u);
}

TEST(MeshImages, AMissingFileIsTheProblemOfTheField) {
  LayeredSession s;
  const ItemId lost = s.session->apply(AddLayer{layer_named("lost")});
  s.session->apply(SetImages{s.mesh, {lost, {}}});
  const Advance done = s.session->advance_steps(5);
  ASSERT_FALSE(done.warnings.empty());
  EXPECT_NE(done.warnings.front().find("its file is missing"), std::string::npos);
  EXPECT_FALSE(first_mesh(*s.session).field->problem.empty());
  EXPECT_GT(s.resampled, 0);
}

}  // namespace
}  // namespace simplexseg
