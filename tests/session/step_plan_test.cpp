// SPDX-License-Identifier: Apache-2.0
// The plan lists exactly the arrays and kernels of the engine.
#include "session/step_plan.h"

#include <algorithm>
#include <map>
#include <set>

#include "session/session.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

class StepPlanTest : public EngineTest {
 protected:
  static Scene scene_with(const ForceParameters& forces, int vertices = 80) {
    Scene scene;
    scene.simulation = simplexseg::simulation(0.5f, 0.9f, 3);
    scene.simulation.start_vertices = scene.simulation.final_vertices = static_cast<float>(vertices);
    scene.simulation.finest_edge = 0;
    MeshItem item;
    item.name = "ball", item.seed = {{0, 0, 0}, 18}, item.parameters = forces;
    scene.meshes.push_back(item);
    return scene;
  }
  /// Compares the plan of a session with the arrays and kernels of its engine.
  static void check(Session& session, const std::string& what) {
    SCOPED_TRACE(what);
    const StepPlan plan = session.plan();
    std::map<std::string, std::size_t> planned, allocated;
    std::set<std::string> listed, planned_kernels, run_kernels;
    for (const StepPlan::Item& item : plan.items) {
      EXPECT_TRUE(item.what == "array" || item.what == "kernel") << item.what;
      EXPECT_TRUE(listed.insert(item.what + " " + item.name).second) << item.name << " is listed twice";
      EXPECT_FALSE(item.why.empty()) << item.name;
      EXPECT_EQ(item.needed, item.bytes > 0) << item.name;
      if (item.needed && item.what == "array") planned[item.name] = item.bytes;
      if (item.needed && item.what == "kernel") planned_kernels.insert(item.name);
    }
    for (const Engine::AllocatedArray& array : session.engine().allocated_arrays())
      if (array.bytes > 0) allocated[array.name] = array.bytes;
    // A device packs neighbours whose indices are close.
    if (GetParam() == "cuda" && planned.contains("neighbours")) {
      EXPECT_LE(allocated["neighbours"], planned["neighbours"]);
      allocated["neighbours"] = planned["neighbours"];
    }
    EXPECT_EQ(planned, allocated);
    EXPECT_GE(plan.bytes_allocated(), session.engine().bytes_allocated());
    for (const Engine::KernelCount& kernel : session.engine().kernel_counts()) run_kernels.insert(kernel.name);
    EXPECT_EQ(planned_kernels, run_kernels);
  }
  /// Session on a new engine, after some steps.
  static std::unique_ptr<Session> opened(Scene scene, const Volume& volume) {
    auto session = std::make_unique<Session>(make_engine());
    session->open(std::move(scene), volume);
    session->advance_steps(4);
    return session;
  }
};
SIMPLEXSEG_ON_EVERY_BACKEND(StepPlanTest);

TEST_P(StepPlanTest, EachForceAlone) {
  for (const ForceInfo& force : force_list())
    for (bool with_point : {false, true}) {
      ForceParameters forces = weightless();
      weight_of(forces, force.id) = 0.3f;
      Scene scene = scene_with(forces);
      if (with_point) scene.meshes[0].id = 1, scene.points.push_back({2, 1, {0, 0, 21}});
      check(*opened(scene, phantom("sphere").image), std::string(force.name) + (with_point ? " with a point" : ""));
    }
}

TEST_P(StepPlanTest, AreasAndMassesOnlyWhereTheyAreUsed) {
  ForceParameters forces = weightless();
  weight_of(forces, ForceId::Smoothing) = 0.3f;
  for (float SimulationParameters::*share :
       {&SimulationParameters::area_in_mass, &SimulationParameters::area_in_force}) {
    Scene scene = scene_with(forces);
    const auto needed = [](Session& session) {
      const StepPlan plan = session.plan();
      return std::count_if(plan.items.begin(), plan.items.end(), [](const StepPlan::Item& item) {
        return item.needed && (item.name == "areas" || item.name == "masses" || item.name == "areas and masses");
      });
    };
    EXPECT_EQ(needed(*opened(scene, {})), 0);
    scene.simulation.*share = 0.5f;
    const auto session = opened(scene, {});
    check(*session, "with areas");
    EXPECT_EQ(needed(*session), 3);
    scene.simulation.solver_choice = static_cast<float>(Solver::Automatic);
    const auto automatic = opened(scene, {});
    check(*automatic, "solver automatic");
    EXPECT_EQ(needed(*automatic), 0);
    // The arrays are released when the shares become 0.
    SetParameters without{0, scene.meshes[0].parameters, session->scene().simulation};
    (*without.simulation).*share = 0;
    session->apply(without);
    session->advance_steps(4);
    EXPECT_EQ(needed(*session), 0);
    for (const Engine::AllocatedArray& array : session->engine().allocated_arrays())
      EXPECT_TRUE(array.bytes == 0 || (array.name != "areas" && array.name != "masses")) << array.name;
  }
}

TEST_P(StepPlanTest, AllForcesOnSeveralMeshes) {
  ForceParameters forces = weightless();
  for (const ForceInfo& force : force_list()) weight_of(forces, force.id) = 0.3f;
  Scene scene = scene_with(forces);
  scene.meshes[0].id = 1;
  scene.points = {{7, 1, {0, 0, 21}}, {8, 1, {0, 20, 0}}, {9, 1, {20, 0, 0}}};
  scene.meshes.push_back(scene.meshes[0]);
  scene.meshes[1].id = 2, scene.meshes[1].name = "other", scene.meshes[1].seed.centre_mm = {4, 4, 4};
  scene.meshes[1].mesh = make_sphere({4, 4, 4}, 6, 3);
  const auto session = opened(scene, phantom("sphere").image);
  check(*session, "without profiles");
  session->apply(RecordProfiles{2});
  session->advance_steps(4);
  check(*session, "one of them with profiles");
  Scene saved = session->scene();
  set(saved.meshes[0].parameters, {"intensity_profile", "half_length", 2});
  const auto another = opened(saved, phantom("sphere").image);
  another->apply(RecordProfiles{0});
  another->advance_steps(4);
  check(*another, "profiles of two lengths");
  another->apply(DeleteMesh{1});
  check(*opened(another->scene(), phantom("sphere").image), "one mesh fewer");
}

TEST_P(StepPlanTest, VariantsOfTheEvidenceForce) {
  for (float local : {0.0f, 0.5f})
    for (float averaging : {0.0f, 2.0f})
      for (int final_vertices : {80, 320}) {
        Scene scene = scene_with(
            with({{"evidence", "weight", 0.5f}, {"evidence", "local", local}, {"evidence", "averaging", averaging}}));
        scene.simulation.final_vertices = static_cast<float>(final_vertices);
        check(*opened(scene, phantom("sphere").image), "local " + std::to_string(local) + ", averaging " +
                                                           std::to_string(averaging) + ", to " +
                                                           std::to_string(final_vertices));
      }
}

TEST_P(StepPlanTest, WithoutVolumeOrMesh) {
  ForceParameters forces = weightless();
  for (const ForceInfo& force : force_list()) weight_of(forces, force.id) = 0.1f;
  check(*opened(scene_with(forces), {}), "no volume");
  Scene none = scene_with(forces);
  none.meshes.clear();
  check(*opened(none, phantom("sphere").image), "no mesh");
  check(*opened(none, {}), "nothing");
}

TEST_P(StepPlanTest, WeightsThatChangeBetweenSteps) {
  const auto session = opened(scene_with(weightless()), phantom("sphere").image);
  check(*session, "no active force");
  for (ForceId force : {ForceId::Evidence, ForceId::Gradient, ForceId::ShapeMemory}) {
    session->apply(SetForceParameter{0, force, 0, 0.5f});
    session->advance_steps(4);
    check(*session, "on");
  }
  // Kernel counts start with the engine, so only arrays show that a force was switched off.
  for (ForceId force : {ForceId::Gradient, ForceId::Evidence, ForceId::ShapeMemory})
    session->apply(SetForceParameter{0, force, 0, 0});
  std::set<std::string> planned, allocated;
  for (const StepPlan::Item& item : session->plan().items)
    if (item.needed && item.what == "array") planned.insert(item.name);
  for (const Engine::AllocatedArray& array : session->engine().allocated_arrays()) allocated.insert(array.name);
  EXPECT_EQ(planned, allocated);
  EXPECT_FALSE(allocated.contains("evidence targets"));
}

TEST_P(StepPlanTest, ReadsNoPose) {
  const auto session = opened(scene_with(with({{"smoothing", "weight", 1}})), phantom("sphere").image);
  session->scene();
  session->advance_steps(2);
  const Eigen::Vector3f before = session->scene_without_poses().meshes[0].mesh.positions[0];
  const std::uint64_t read = session->engine().bytes_read_back();
  session->plan();
  EXPECT_EQ(session->engine().bytes_read_back(), read);
  EXPECT_EQ(session->scene_without_poses().meshes[0].mesh.positions[0], before);
  EXPECT_NE(session->scene().meshes[0].mesh.positions[0], before);
}

TEST_P(StepPlanTest, ReasonsNameTheMissingInput) {
  ForceParameters forces =
      with({{"attraction", "weight", 1}, {"intensity_profile", "weight", 1}, {"evidence", "weight", 1}});
  Scene scene = scene_with(forces);
  auto why = [](const StepPlan& plan, const std::string& name) {
    for (const StepPlan::Item& item : plan.items)
      if (item.name == name) return item.why;
    return std::string("not listed");
  };
  const StepPlan plan = opened(scene, phantom("sphere").image)->plan();
  EXPECT_NE(why(plan, "gradient targets").find("weight of gradient is 0"), std::string::npos)
      << why(plan, "gradient targets");
  EXPECT_NE(why(plan, "attraction sums").find("no attraction point"), std::string::npos)
      << why(plan, "attraction sums");
  EXPECT_NE(why(plan, "reference profiles").find("none was recorded"), std::string::npos)
      << why(plan, "reference profiles");
  EXPECT_NE(why(plan, "evidence targets").find("ball"), std::string::npos) << why(plan, "evidence targets");
  EXPECT_NE(why(opened(scene, {})->plan(), "evidence targets").find("no volume"), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
