// SPDX-License-Identifier: Apache-2.0
#include "session_fixture.h"

#include "session/lasso.h"
#include "step/simulation_parameters.h"

#include <cstring>

namespace simplexseg {
namespace {

template <class T>
bool same_bytes(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(static_cast<const void*>(a.data()), b.data(), a.size() * sizeof(T)) == 0);
}
bool same_values(const RegionModel& a, const RegionModel& b) {
  return a.low == b.low && a.high == b.high && a.object == b.object && a.background == b.background;
}
bool same_values(const SolverState& a, const SolverState& b) {
  return a.min_eigenvalue == b.min_eigenvalue && a.multigrid == b.multigrid && a.regularisation == b.regularisation;
}
bool same_values(const Seed& a, const Seed& b) { return a.centre_mm == b.centre_mm && a.radius_mm == b.radius_mm; }
bool same_values(const MeshItem& a, const MeshItem& b, const char*& what) {
  const auto same = [&what](bool is, const char* name) {
    if (!is) what = name;
    return is;
  };
  const auto values = [](const MeshItem& item) {
    return item.field ? item.field->values : std::vector<std::uint16_t>();
  };
  return same(a.id == b.id, "the meshes") && same(a.name == b.name, "the names") &&
         same(a.colour == b.colour, "the colours") && same(a.visible == b.visible, "the visibilities") &&
         same(a.label == b.label, "the labels") && same(a.code == b.code, "the codes") &&
         same(a.locked == b.locked && a.opacity == b.opacity, "locks and opacities") &&
         same(same_values(a.seed, b.seed), "the seeds") &&
         same(std::memcmp(&a.parameters, &b.parameters, sizeof a.parameters) == 0, "the force parameters") &&
         same(same_bytes(a.mesh.positions, b.mesh.positions), "the positions") &&
         same(a.mesh.neighbours == b.mesh.neighbours, "the neighbours") &&
         same(same_bytes(a.previous, b.previous), "the previous positions") &&
         same(same_bytes(a.shape, b.shape), "the shape references") &&
         same(same_bytes(a.profiles, b.profiles), "the profiles") &&
         same(same_values(a.region, b.region), "the region models") && same(values(a) == values(b), "the fields") &&
         same(same_values(a.solver, b.solver), "the solver states") && same(a.edge_mm == b.edge_mm, "the mean edges") &&
         same(a.steps_at_level == b.steps_at_level && a.final_vertices == b.final_vertices && a.rebuilt == b.rebuilt,
              "the levels");
}
bool same_values(const UserPoint& a, const UserPoint& b) {
  return a.id == b.id && a.mesh == b.mesh && a.position_mm == b.position_mm && a.kind == b.kind &&
         a.radius_mm == b.radius_mm && a.outward == b.outward;
}

}  // namespace

SessionState state_of(const Session& session) { return {session.scene()}; }

::testing::AssertionResult same_state(const SessionState& a, const SessionState& b) {
  auto differs = [](const char* what) { return ::testing::AssertionFailure() << what << " differ"; };
  const Scene &x = a.scene, &y = b.scene;
  if (x.meshes.size() != y.meshes.size()) return differs("the counts of meshes");
  const char* what = "";
  for (std::size_t k = 0; k < x.meshes.size(); ++k)
    if (!same_values(x.meshes[k], y.meshes[k], what)) return differs(what);
  if (!std::equal(x.points.begin(), x.points.end(), y.points.begin(), y.points.end(),
                  [](const UserPoint& p, const UserPoint& q) { return same_values(p, q); }))
    return differs("the points");
  if (x.measurements != y.measurements) return differs("the measurements");
  if (x.layers != y.layers) return differs("the layers");
  if (x.volume_preprocessing != y.volume_preprocessing) return differs("the filters of the volume");
  if (std::memcmp(&x.simulation, &y.simulation, sizeof x.simulation) != 0)
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

const Volume& ball_image() { return phantom("sphere", 100, 10).image; }
const MeshItem& first_mesh(const Session& session) { return session.scene().meshes.at(0); }

std::unique_ptr<Session> open_session(int threads, Scene scene) {
  auto session = std::make_unique<Session>(make_cpu_engine(threads));
  session->open(std::move(scene), ball_image());
  return session;
}

std::unique_ptr<Session> open_with_field(int threads) {
  Scene scene = ball_scene();
  set(scene.forces, {"evidence", "source", 0});
  scene.meshes[0].parameters = scene.forces;
  auto session = std::make_unique<Session>(make_cpu_engine(threads), nullptr, threads);
  session->open(std::move(scene), ball_image());
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
    ADD_FAILURE() << title_of(command) << " was executed";
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
