// SPDX-License-Identifier: Apache-2.0
// Filters of the volume in a session: values, fields, undo, replay, refusal.
#include <algorithm>

#include "session_fixture.h"

namespace simplexseg {
namespace {

/// Values times the first parameter of the filter.
Volume scaled_volume(const Volume& volume, const FilterStep& step) {
  Volume result(volume.geometry(), VoxelType::Float32);
  const VolumeGeometry& grid = volume.geometry();
  for (int k = 0; k < grid.size[2]; ++k)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int i = 0; i < grid.size[0]; ++i)
        result.voxels<float>()[result.offset(i, j, k)] = static_cast<float>(step.parameters[0] * volume.value(i, j, k));
  return result;
}

FilterVolume scaling(std::initializer_list<double> factors) {
  FilterVolume command;
  for (const double factor : factors) command.preprocessing.filters.push_back({FilterKind::Uptake, {factor}});
  return command;
}

std::unique_ptr<Session> open_with_filters(bool field) {
  auto session = field ? open_with_field() : open_session();
  session->set_volume_filter(scaled_volume);
  return session;
}

double centre_value(const Session& session) { return session.volume().value(32, 32, 32); }

TEST(VolumeFilters, ChangeTheValuesWithUndoAndKeepTheOriginal) {
  const auto session = open_with_filters(false);
  const double original = centre_value(*session);
  const VoxelType type = session->volume().type();
  session->apply(scaling({2}));
  EXPECT_EQ(centre_value(*session), 2 * original);
  session->apply(scaling({2, 3}));
  EXPECT_EQ(centre_value(*session), 6 * original);
  EXPECT_EQ(session->history().undo_names().back(), "filter volume");
  const SessionState twice = state_of(*session);
  session->apply(Undo{});
  EXPECT_EQ(centre_value(*session), 2 * original);
  session->apply(Undo{});
  EXPECT_EQ(centre_value(*session), original);
  EXPECT_EQ(session->volume().type(), type);
  EXPECT_EQ(session->volume().data(), ball_image().data());  // not a copy
  session->set_volume_filter({});                            // all results are in memory
  session->apply(Redo{});
  session->apply(Redo{});
  EXPECT_EQ(centre_value(*session), 6 * original);
  EXPECT_TRUE(same_state(state_of(*session), twice));
  session->apply(scaling({}));
  EXPECT_EQ(centre_value(*session), original);
  EXPECT_EQ(session->history().undo_names().back(), "remove filters of volume");
}

TEST(VolumeFilters, FieldsAreSolvedAgainWithTheFilteredValues) {
  const auto session = open_with_filters(true);
  session->advance_steps(20);
  const std::shared_ptr<const MeshField> before = first_mesh(*session).field;
  ASSERT_TRUE(before);
  session->apply(scaling({0.5, 7}));
  EXPECT_EQ(first_mesh(*session).field, before);  // until the next steps
  session->advance_steps(20);
  const std::shared_ptr<const MeshField> filtered = first_mesh(*session).field;
  EXPECT_NE(filtered, before);
  EXPECT_FALSE(filtered->filters.empty());
  session->advance_steps(20);
  EXPECT_EQ(first_mesh(*session).field, filtered);
  session->apply(Undo{});
  EXPECT_EQ(first_mesh(*session).field, before);
  session->advance_steps(20);
  EXPECT_EQ(first_mesh(*session).field, before);  // it fits the values again
}

TEST(VolumeFilters, AReplayHasTheSameBits) {
  const auto live = open_with_filters(true), replayed = open_with_filters(true);
  live->advance(0.05);
  live->apply(scaling({2}));
  live->advance(0.05);  // a field may still be solved in the background
  live->apply(scaling({2, 0.25}));
  live->advance_steps(30);
  live->apply(Undo{});
  live->advance(0.05);
  live->apply(Redo{});
  live->advance_steps(10);
  replayed->replay(live->log(), live->steps_since_last_command());
  EXPECT_EQ(centre_value(*replayed), centre_value(*live));
  EXPECT_TRUE(same_state(state_of(*replayed), state_of(*live)));
}

TEST(VolumeFilters, TheEngineUsesTheFilteredValues) {
  // Without a field, the region force reads voxels directly: other values move the surface otherwise.
  const auto plain = open_with_filters(false), filtered = open_with_filters(false);
  filtered->set_volume_filter([](const Volume& volume, const FilterStep& step) {
    Volume result = scaled_volume(volume, step);
    const auto voxels = result.voxels<float>();
    std::fill(voxels.begin(), voxels.begin() + static_cast<std::ptrdiff_t>(voxels.size() / 2), 0.0f);
    return result;
  });
  filtered->apply(scaling({1}));
  plain->advance_steps(30), filtered->advance_steps(30);
  EXPECT_NE(first_mesh(*plain).mesh.positions, first_mesh(*filtered).mesh.positions);
}

TEST(VolumeFilters, RefuseWhatTheVolumeCannotHave) {
  const auto session = open_with_filters(false);
  FilterVolume isotropic;
  isotropic.preprocessing.filters = {{FilterKind::Isotropic, {0}}};
  EXPECT_NE(refusal(*session, isotropic).find("grid"), std::string::npos);
  EXPECT_NE(refusal(*session, scaling({-1, 1})).find("factor"), std::string::npos);
  FilterVolume incomplete;
  incomplete.preprocessing.filters = {{FilterKind::Median, {}}};
  EXPECT_NE(refusal(*session, incomplete).find("incomplete"), std::string::npos);
  session->set_volume_filter({});
  EXPECT_NE(refusal(*session, scaling({3})).find("no filters"), std::string::npos);
  session->set_volume_filter([](const Volume&, const FilterStep&) -> Volume { throw Error("a", "b", "c"); });
  EXPECT_EQ(refusal(*session, scaling({3})), Error("a", "b", "c").what());
  EXPECT_EQ(session->volume().data(), ball_image().data());
}

TEST(VolumeFilters, AreDescribedForUsersAndFiles) {
  const std::vector<FilterStep> filters{{FilterKind::BiasField, {4, 4, 50}}, {FilterKind::Diffusion, {5, 1.0 / 3}}};
  EXPECT_EQ(key_of(filters),
            "n4(shrink=4,levels=4,iterations=50);diffusion(iterations=5,conductance=0.33333333333333331)");
  EXPECT_EQ(describe(filters),
            "N4 bias field correction (shrink 4, levels 4, iterations 50), then Anisotropic diffusion (iterations 5, "
            "conductance 0.333333)");
  EXPECT_EQ(type_after(filters, VoxelType::Int16), VoxelType::Float32);
  EXPECT_EQ(type_after({}, VoxelType::Int16), VoxelType::Int16);
  for (const FilterInfo& info : filter_list()) {
    EXPECT_EQ(find_filter(info.name), info.kind);
    EXPECT_EQ(&info_of(info.kind), &info);
    check_filter({info.kind, default_parameters(info.kind)});
  }
  EXPECT_EQ(find_filter("n5"), std::nullopt);
}

}  // namespace
}  // namespace simplexseg
