// SPDX-License-Identifier: Apache-2.0
// Life cycle of a mesh from its sphere to its finest level.
#include "session/mesh_lifecycle.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "image/volume.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

MeshItem ball(int level) {
  MeshItem item;
  item.seed = {{1, 2, 3}, 10};
  item.mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, level);
  return item;
}

TEST(MeshLifecycle, AMeshMovesSettlesOrIsRefined) {
  SimulationParameters simulation = default_simulation_parameters();
  simulation.rest_tolerance_voxels = 0.01f, simulation.steps_per_level = 100;
  simulation.final_vertices = 320, simulation.finest_edge = 0;
  const auto state = [&](const MeshItem& item, float move_mm) {
    return level_state(item, simulation, Volume(), move_mm, 3.0f);
  };
  MeshItem coarse = ball(1), fine = ball(2);
  EXPECT_EQ(state(coarse, 1.0f), LevelState::Moving);
  EXPECT_EQ(state(coarse, 0.001f), LevelState::RefinementDue) << "settled";
  EXPECT_EQ(state(fine, 1.0f), LevelState::Moving);
  EXPECT_EQ(state(fine, 0.001f), LevelState::Settled);
  coarse.steps_at_level = fine.steps_at_level = 100;
  EXPECT_EQ(state(coarse, 1.0f), LevelState::RefinementDue) << "its steps are used up";
  EXPECT_EQ(state(fine, 1.0f), LevelState::Moving) << "no limit of steps on the finest level";
  simulation.finest_edge = 4;
  EXPECT_EQ(state(coarse, 0.001f), LevelState::Settled) << "its edges are as long as voxels";
}

TEST(MeshLifecycle, TheToleranceOfTheMotionGrowsWithTheSteps) {
  SimulationParameters simulation = default_simulation_parameters();
  simulation.rest_tolerance_voxels = 0.01f, simulation.final_vertices = 320, simulation.finest_edge = 0;
  MeshItem item = ball(2);
  const auto state = [&](int steps, float move_mm) {
    item.sleep.awake_steps = steps;
    return level_state(item, simulation, Volume(), move_mm, 3.0f);
  };
  EXPECT_EQ(state(999, 0.0101f), LevelState::Moving);
  EXPECT_EQ(state(999, 0.0099f), LevelState::Settled);
  EXPECT_EQ(state(2900, 0.03f), LevelState::Moving);
  EXPECT_EQ(state(3100, 0.03f), LevelState::Settled);
  simulation.rest_tolerance_voxels = 0;
  EXPECT_EQ(state(1'000'000, 0.03f), LevelState::Moving) << "no tolerance";
}

TEST(MeshLifecycle, AMeshWithAPoseIsCompleted) {
  const SimulationParameters simulation = default_simulation_parameters();
  MeshItem item = ball(1);
  const std::vector<Eigen::Vector3f> pose = item.mesh.positions;
  complete(item, simulation, Volume());
  EXPECT_EQ(item.mesh.positions, pose);
  EXPECT_EQ(item.previous, pose);
  EXPECT_EQ(item.shape.size(), pose.size());
  item.previous[0] += Eigen::Vector3f(1, 0, 0);
  const std::vector<Eigen::Vector3f> previous = item.previous;
  complete(item, simulation, Volume());
  EXPECT_EQ(item.previous, previous) << "existing state stays";
}

TEST(MeshLifecycle, RefinementKeepsProfilesAndResetsTheSolver) {
  MeshItem item = ball(1);
  const int coarse = item.mesh.vertex_count();
  for (int v = 0; v < coarse; ++v) item.profiles.insert(item.profiles.end(), {float(v), float(-v)});
  item.steps_at_level = 7, item.solver.min_eigenvalue = 0.5f;
  refine_item(item);
  ASSERT_EQ(item.mesh.vertex_count(), 4 * coarse);
  ASSERT_EQ(item.profiles.size(), std::size_t(8 * coarse));
  for (int v = 0; v < coarse; ++v) EXPECT_EQ(item.profiles[2 * v], float(v)) << "old vertices keep theirs";
  for (int v = 0; v < 4 * coarse; ++v) EXPECT_EQ(item.profiles[2 * v], -item.profiles[2 * v + 1]);
  EXPECT_EQ(item.previous, item.mesh.positions);
  EXPECT_EQ(item.steps_at_level, 0);
  EXPECT_EQ(item.solver.min_eigenvalue, 0);
  EXPECT_THROW(record_profiles(item, Volume()), Error);
}

}  // namespace
}  // namespace simplexseg
