// SPDX-License-Identifier: Apache-2.0
#include "session_fixture.h"
#include "step/simulation_parameters.h"

#include <cstring>

namespace simplexseg {
namespace {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), b.data(), a.size() * sizeof(T)) == 0);
}
template <class T>
bool same_bytes(const std::vector<std::vector<T>>& a, const std::vector<std::vector<T>>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return same_bytes(x, y); });
}

}  // namespace

SessionState state_of(const Session& session) {
  SessionState state;
  const Scene& scene = session.scene();
  for (const MeshItem& item : scene.meshes) {
    state.positions.push_back(item.mesh.positions), state.previous.push_back(item.previous),
        state.shapes.push_back(item.shape);
    state.profiles.push_back(item.profiles), state.parameters.push_back(item.parameters),
        state.names.push_back(item.name);
    state.ids.push_back(item.id), state.labels.push_back(item.label),
        state.steps_at_level.push_back(item.steps_at_level);
    state.final_vertices.push_back(item.final_vertices);
  }
  for (const UserPoint& point : scene.points) state.points.push_back({point.id, point.position_mm});
  state.simulation = scene.simulation;
  return state;
}

::testing::AssertionResult same_state(const SessionState& a, const SessionState& b) {
  auto differs = [](const char* what) { return ::testing::AssertionFailure() << what << " differ"; };
  if (a.ids != b.ids) return differs("the meshes");
  if (a.names != b.names) return differs("the names");
  if (a.labels != b.labels) return differs("the labels");
  if (!same_bytes(a.positions, b.positions)) return differs("the positions");
  if (!same_bytes(a.previous, b.previous)) return differs("the positions of the step before");
  if (!same_bytes(a.shapes, b.shapes)) return differs("the shape references");
  if (!same_bytes(a.profiles, b.profiles)) return differs("the profiles");
  if (!same_bytes(a.parameters, b.parameters)) return differs("the force parameters");
  if (a.points != b.points) return differs("the points");
  if (a.steps_at_level != b.steps_at_level || a.final_vertices != b.final_vertices) return differs("the levels");
  if (std::memcmp(&a.simulation, &b.simulation, sizeof a.simulation) != 0)
    return differs("the simulation's parameters");
  return ::testing::AssertionSuccess();
}

Scene ball_scene() {
  Scene scene;
  scene.simulation = limited(1, 0.9f, 3);
  scene.simulation.start_vertices = 320, scene.simulation.final_vertices = 1280;
  scene.simulation.finest_edge = 0, scene.simulation.steps_per_level = 100,
  scene.simulation.rest_tolerance_voxels = 0.002f;
  scene.forces = with({{"smoothing", "weight", 0.5f}, {"evidence", "weight", 0.5f}, {"attraction", "weight", 2}});
  MeshItem item;
  item.name = "ball", item.seed = {{1, -2, 0.5}, 12}, item.parameters = scene.forces;
  scene.meshes.push_back(item);
  return scene;
}

std::unique_ptr<Session> open_session(int threads, Scene scene) {
  auto session = std::make_unique<Session>(make_cpu_engine(threads));
  session->open(std::move(scene), phantom("sphere", 100, 10).image);
  return session;
}

int simulation_index(const char* name) {
  const int index = find_parameter(simulation_table(), name);
  EXPECT_GE(index, 0) << name;
  return index;
}
int parameter_index(const char* force, const char* parameter) {
  const int index = find_parameter(find_force(force)->parameters, parameter);
  EXPECT_GE(index, 0) << parameter;
  return index;
}

std::string refusal(Session& session, const Command& command) {
  const SessionState before = state_of(session);
  const std::size_t log = session.log().size();
  const bool can_undo = session.can_undo(), can_redo = session.can_redo();
  std::string message;
  try {
    session.apply(command);
    ADD_FAILURE() << title_of(command) << " was carried out";
  } catch (const Error& error) {
    message = error.what();
  }
  EXPECT_TRUE(same_state(state_of(session), before)) << message;
  EXPECT_EQ(session.log().size(), log) << message;
  EXPECT_EQ(session.can_undo(), can_undo) << message;
  EXPECT_EQ(session.can_redo(), can_redo) << message;
  EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  return message;
}

}  // namespace simplexseg
