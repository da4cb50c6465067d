// SPDX-License-Identifier: Apache-2.0
// Models in a session: fields, undo, replay and refusals.
#include "core/error.h"
#include "forces/force_list.h"
#include "image/rasterise.h"
#include "model/model_training.h"
#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Model of the ball in the image.
std::shared_ptr<const MeshModel> ball_model() {
  static const std::shared_ptr<const MeshModel> model = [] {
    const Volume& image = ball_image();
    std::vector<ModelCase> cases{{"ball", image, mask_of(phantom("sphere", 100, 10).labels, 1.0), {}}};
    const TrainingSettings settings{.vertices = 300, .modes = 10};
    auto made = std::make_shared<MeshModel>();
    made->path = "ball.model", made->checksum = "crc32-of-ball";
    made->organ = std::make_shared<const OrganModel>(
        train_model(register_cases(cases, settings, run_serially()), settings, run_serially()));
    return made;
  }();
  return model;
}

TEST(MeshModels, ChangeTheFieldAndUndoRestoresIt) {
  const auto session = open_with_field();
  session->advance_steps(50);
  const auto before = first_mesh(*session).field;
  EXPECT_EQ(before->model, "");
  const ItemId mesh = first_mesh(*session).id;
  session->apply(SetModel{mesh, ball_model()});
  session->advance_steps(1);
  const auto with_model = first_mesh(*session).field;
  EXPECT_NE(with_model, before);
  EXPECT_EQ(with_model->model, "crc32-of-ball");
  EXPECT_NE(with_model->values, before->values);
  EXPECT_EQ(session->history().undo_names().front().substr(0, 9), "set model");
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, before);
  EXPECT_EQ(first_mesh(*session).model, nullptr);
  session->apply(Redo{});
  session->advance_steps(1);
  EXPECT_EQ(first_mesh(*session).field->values, with_model->values);
  session->apply(SetModel{mesh, nullptr});
  session->advance_steps(1);
  EXPECT_EQ(first_mesh(*session).field->model, "");
}

TEST(MeshModels, ReportTheShareOfTheirPriorInTheField) {
  const auto session = open_with_field();
  session->advance_steps(1);
  EXPECT_EQ(first_mesh(*session).field->model_trust, 0);
  session->apply(SetModel{first_mesh(*session).id, ball_model()});
  session->advance_steps(1);
  EXPECT_GT(first_mesh(*session).field->model_trust, 0.25f);
  EXPECT_LE(first_mesh(*session).field->model_trust, 1);
}

TEST(MeshModels, AreTheStartShapeOfASurface) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_NE(refusal(*session, SetStartModes{mesh, {1}}).find("no model"), std::string::npos);
  session->apply(SetModel{mesh, ball_model()});
  session->advance_steps(1);
  const std::vector<Eigen::Vector3f> before = first_mesh(*session).mesh.positions;
  session->apply(SetStartModes{mesh, {2}});
  const SimplexMesh longer = first_mesh(*session).mesh;
  EXPECT_EQ(longer.neighbours, ball_model()->organ->shape.mean.neighbours);
  session->apply(SetStartModes{mesh, {-2}, true});
  EXPECT_NE(first_mesh(*session).mesh.positions, longer.positions);
  // The drag of a slider is undone at once.
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).mesh.positions, before);
  EXPECT_TRUE(first_mesh(*session).start_modes.empty());
  session->apply(Redo{});
  EXPECT_EQ(first_mesh(*session).start_modes, (std::vector<float>{-2}));
  // A reset starts from this shape, and from the sphere again without modes.
  const std::vector<Eigen::Vector3f> start = first_mesh(*session).mesh.positions;
  session->advance_steps(20);
  EXPECT_NE(first_mesh(*session).mesh.positions, start);
  session->apply(ResetPose{mesh});
  EXPECT_EQ(first_mesh(*session).mesh.positions, start);
  session->apply(SetStartModes{mesh, {}});
  EXPECT_NE(first_mesh(*session).mesh.neighbours, longer.neighbours);
  EXPECT_NE(refusal(*session, SetStartModes{mesh, {9}}).find("-5 to 5"), std::string::npos);
  EXPECT_NE(refusal(*session, SetStartModes{mesh, std::vector<float>(11, 0)}).find("only 10"), std::string::npos);
  session->apply(SetStartModes{mesh, {1, 0.5f}});
  session->advance_steps(10);
  const auto replayed = open_with_field();
  replayed->replay(session->log(), session->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*session), state_of(*replayed)));
  session->apply(SetModel{mesh, nullptr});
  EXPECT_TRUE(first_mesh(*session).start_modes.empty());
}

TEST(MeshModels, OfAnAddedSegmentationReplayToTheSameBits) {
  const auto live = open_with_field();
  live->advance_steps(10);
  AddMesh add{};
  add.name = "second", add.seed = {{2, 0, 0}, 14};
  add.model = ball_model();
  live->apply(DeleteMesh{first_mesh(*live).id});
  const ItemId mesh = live->apply(add);
  live->advance_steps(30);
  live->apply(AddPoint{mesh, {22, 0, 0}, MarkKind::Outside, 2});
  live->advance_steps(20);
  EXPECT_EQ(first_mesh(*live).field->model, "crc32-of-ball");
  const auto replayed = open_with_field();
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*live), state_of(*replayed)));
}

TEST(MeshModels, AreRefusedWithoutContentsAndForLockedOnesAndOnesThatStartFromAMesh) {
  const auto session = open_with_field();
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_NE(refusal(*session, SetModel{mesh, std::make_shared<const MeshModel>()}).find("not read"), std::string::npos);
  AddMesh add{};
  add.name = "from mesh", add.seed = {{0, 0, 0}, 15};
  add.start = MeshStart{"a.ply", std::nullopt, 0, std::make_shared<const SimplexMesh>(make_sphere({0, 0, 0}, 10, 2))};
  const ItemId from_mesh = session->apply(add);
  EXPECT_NE(refusal(*session, SetModel{from_mesh, ball_model()}).find("start it from a seed"), std::string::npos);
  session->apply(EditMesh{mesh, {}, {}, {}, {}, true});
  EXPECT_NE(refusal(*session, SetModel{mesh, ball_model()}).find("locked"), std::string::npos);
}

/// Session with a ball that starts from the shape of its model, 1 mm and more inside the edge of the object, and that
/// only profiles and smoothing move. `measure`: of profiles.
std::unique_ptr<Session> session_of_profiles(float measure) {
  Scene scene = ball_scene();
  scene.meshes[0].seed = {{0, 0, 0}, 15};
  scene.meshes[0].parameters = with({{"intensity_profile", "weight", 0.5f},
                                     {"intensity_profile", "measure", measure},
                                     {"smoothing", "weight", 0.2f}});
  scene.meshes[0].model = ball_model();
  scene.meshes[0].start_modes = {0};
  return open_session(1, std::move(scene));
}
double mean_radius(const Session& session) {
  double sum = 0;
  for (const Eigen::Vector3f& p : first_mesh(session).mesh.positions) sum += p.norm();
  return sum / first_mesh(session).mesh.vertex_count();
}

TEST(ModelProfiles, MoveASurfaceToTheEdgeOfTheModelWhereRecordedOnesHoldIt) {
  for (const float measure : {0.0f, 1.0f}) {
    const auto session = session_of_profiles(measure);
    const ItemId mesh = first_mesh(*session).id;
    const double start = mean_radius(*session);
    ASSERT_LT(start, kPhantomRadius - 1);
    session->apply(RecordProfiles{mesh});
    session->advance_steps(100);
    EXPECT_NEAR(mean_radius(*session), start, 0.3) << "measure " << measure;
    session->apply(ResetPose{mesh});
    session->apply(RecordProfiles{mesh, true});
    session->advance_steps(100);
    EXPECT_NEAR(mean_radius(*session), kPhantomRadius, 0.3) << "measure " << measure;
  }
}

TEST(ModelProfiles, StayWithResetsLevelsUndoAndReplay) {
  const auto session = session_of_profiles(0);
  const ItemId mesh = first_mesh(*session).id;
  EXPECT_TRUE(first_mesh(*session).profiles.empty());
  session->apply(RecordProfiles{mesh, true});
  const std::vector<float> profiles = first_mesh(*session).profiles;
  ASSERT_FALSE(profiles.empty());
  session->apply(Undo{});
  EXPECT_TRUE(first_mesh(*session).profiles.empty());
  EXPECT_FALSE(first_mesh(*session).model_profiles);
  session->apply(Redo{});
  session->advance_steps(20);
  session->apply(ResetPose{mesh});
  EXPECT_EQ(first_mesh(*session).profiles, profiles) << "a reset restores them";
  session->apply(SetStartModes{mesh, {1}});
  EXPECT_EQ(first_mesh(*session).profiles, profiles) << "another start shape has the same vertices";
  // A refined mesh inherits them, and has the same when they are recorded again.
  session->apply(RefineMesh{mesh});
  const std::vector<float> inherited = first_mesh(*session).profiles;
  EXPECT_EQ(inherited.size(), 4 * profiles.size());
  session->apply(RecordProfiles{mesh, true});
  EXPECT_EQ(first_mesh(*session).profiles, inherited);
  session->advance_steps(20);
  const auto replayed = session_of_profiles(0);
  replayed->replay(session->log(), session->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*session), state_of(*replayed)));
  // Profiles of a pose replace them, also after a reset.
  session->apply(RecordProfiles{mesh});
  session->apply(ResetPose{mesh});
  EXPECT_TRUE(first_mesh(*session).profiles.empty());
}

TEST(ModelProfiles, FollowTheParametersOfTheForce) {
  const auto session = session_of_profiles(0);
  const ItemId mesh = first_mesh(*session).id;
  session->apply(RecordProfiles{mesh, true});
  const std::vector<float> profiles = first_mesh(*session).profiles;
  using Force = IntensityProfileForce;
  const auto set = [&](int parameter, float value) {
    session->apply(SetForceParameter{mesh, Force::id, parameter, value});
  };
  const float half = first_mesh(*session).parameters.values[static_cast<int>(Force::id)][Force::half_length];
  set(Force::half_length, half - 1);
  const std::vector<float> shorter = first_mesh(*session).profiles;
  EXPECT_EQ(shorter.size() * (2 * half + 1), profiles.size() * (2 * half - 1));
  session->apply(RecordProfiles{mesh, true});
  EXPECT_EQ(first_mesh(*session).profiles, shorter) << "those that the command records";
  // The model has no profiles of this length; then the force does not act.
  set(Force::half_length, half), set(Force::spacing, 4);
  EXPECT_TRUE(first_mesh(*session).profiles.empty());
  session->advance_steps(5);
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).profiles, profiles) << "undo restores them";
  session->apply(Redo{});
  SetParameters all{mesh, first_mesh(*session).parameters, {}};
  all.forces.values[static_cast<int>(Force::id)][Force::spacing] = 0.5f;
  session->apply(all);
  EXPECT_EQ(first_mesh(*session).profiles, profiles);
  session->advance_steps(5);
  const auto replayed = session_of_profiles(0);
  replayed->replay(session->log(), session->steps_since_last_command());
  EXPECT_TRUE(same_state(state_of(*session), state_of(*replayed)));
  // A scene that was edited outside the program.
  Scene edited = session->scene();
  edited.meshes[0].parameters.values[static_cast<int>(Force::id)][Force::half_length] = half - 1;
  EXPECT_EQ(first_mesh(*open_session(1, edited)).profiles, shorter);
}

TEST(ModelProfiles, AreRefusedForOtherVerticesAndLongerProfiles) {
  const auto session = session_of_profiles(0);
  const ItemId mesh = first_mesh(*session).id;
  session->apply(SetForceParameter{mesh, ForceId::IntensityProfile, IntensityProfileForce::spacing, 2});
  EXPECT_NE(refusal(*session, RecordProfiles{mesh, true}).find("reduce half_length"), std::string::npos);
  session->apply(Undo{});
  session->apply(RecordProfiles{mesh, true});
  session->apply(SetStartModes{mesh, {}});
  EXPECT_FALSE(first_mesh(*session).model_profiles);
  EXPECT_NE(refusal(*session, RecordProfiles{mesh, true}).find("does not start from the shape"), std::string::npos);
  // A mesh that was rebuilt from its field has other vertices.
  Scene scene = ball_scene();
  scene.meshes[0].model = ball_model();
  scene.meshes[0].start_modes = {0};
  scene.meshes[0].mesh = make_sphere({0, 0, 0}, 14, 2);
  const auto rebuilt = open_session(1, scene);
  EXPECT_NE(refusal(*rebuilt, RecordProfiles{first_mesh(*rebuilt).id, true}).find("no longer has the vertices"),
            std::string::npos);
  // A scene cannot ask for them without a start shape.
  scene.meshes[0].start_modes.clear(), scene.meshes[0].model_profiles = true;
  EXPECT_THROW(open_session(1, scene), Error);
}

}  // namespace
}  // namespace simplexseg
