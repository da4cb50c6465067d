// SPDX-License-Identifier: Apache-2.0
// Comparison of meshes with their fields, and rebuilding, in the background: commit, discarding and replay.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <thread>

#include "core/error.h"
#include "ring_scene.h"
#include "session/field_comparer.h"
#include "session/log_replay.h"
#include "session/mesh_lifecycle.h"

namespace simplexseg {
namespace {

using std::chrono::steady_clock;

/// Long limit that only detects a hang: with a sanitizer and other tests running, a field takes long.
constexpr std::chrono::minutes kHung{5};

/// Holds comparisons in their background thread until they are released.
class Gate {
 public:
  CompareMesh holding(CompareMesh compare = compare_and_rebuild) {
    return [this, compare](const MeshItem& item, bool settled, const SimulationParameters& simulation,
                           const Volume& volume, const StopCheck& check_stop) {
      for (const int own = ++entered_; released_ < own;) {
        check_stop();
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
      return compare(item, settled, simulation, volume, check_stop);
    };
  }
  void release_all() { released_ = 1 << 20; }
  /// Releases the comparisons that the thread has begun.
  void release_current() { released_ = entered_.load(); }

 private:
  std::atomic<int> entered_ = 0, released_ = 0;
};

const Volume& ring_volume() {
  static const Volume image = ring_image();
  return image;
}

std::unique_ptr<Session> open_ring(int threads = 2) {
  auto session = std::make_unique<Session>(make_cpu_engine(threads), nullptr, threads);
  session->open(solved_ring_scene(), ring_volume());
  return session;
}
const MeshItem& ring(const Session& session) { return session.scene_without_poses().meshes.at(0); }
/// Runs frames until `done`. Returns whether it was reached.
template <class Done>
bool run_frames_until(Session& session, Done&& done) {
  const auto hung = steady_clock::now() + kHung;
  while (!done() && steady_clock::now() < hung) session.advance(0.002);
  return done();
}
void expect_same_replayed_comparisons(const Session& live) {
  for (const int threads : {1, 2}) {
    const auto again = open_ring(threads);
    again->replay(live.log(), live.steps_since_last_command());
    EXPECT_TRUE(same_state(state_of(*again), state_of(live))) << threads;
    EXPECT_EQ(again->log().size(), live.log().size());
    EXPECT_EQ(again->total_steps(), live.total_steps());
    for (std::size_t m = 0; m < live.scene().meshes.size(); ++m) {
      const MeshItem &a = again->scene().meshes[m], &b = live.scene().meshes[m];
      EXPECT_EQ(again->is_comparing(a.id), live.is_comparing(b.id));
      EXPECT_EQ(a.fit.disagreement, b.fit.disagreement);
      EXPECT_EQ(a.fit.settled, b.fit.settled);
      EXPECT_EQ(a.sleep.asleep, b.sleep.asleep);
    }
  }
}
template <class C>
int count_of(const Session& session) {
  return static_cast<int>(std::count_if(session.log().begin(), session.log().end(), [](const LogEntry& entry) {
    return std::holds_alternative<C>(entry.command);
  }));
}

/// Number of steps between the last commit of a comparison and the start before it.
int steps_to_last_commit(const Session& session) {
  int steps = 0, last = 0;
  for (const LogEntry& entry : session.log()) {
    steps += entry.steps;
    if (std::holds_alternative<StartFieldComparison>(entry.command)) steps = 0;
    if (std::holds_alternative<CommitFieldComparison>(entry.command)) last = steps;
  }
  return last;
}
constexpr int kHeldSteps = 37;

TEST(FieldComparisons, StepsContinueWhileAMeshIsRebuiltAndTheReplayGivesTheSameBits) {
  Gate gate;
  const auto live = open_ring();
  live->set_field_comparison(gate.holding());
  const auto hung = steady_clock::now() + kHung;
  while (!ring(*live).rebuilt && steady_clock::now() < hung) {
    ASSERT_TRUE(run_frames_until(*live, [&] { return live->is_comparing(1); }));
    const std::int64_t start = live->total_steps();
    // Held comparisons: no frame waits for them, the mesh does not sleep, and the run is not reported as settled.
    while (live->total_steps() < start + kHeldSteps) {
      EXPECT_FALSE(live->advance(0.002).at_rest);
      EXPECT_FALSE(ring(*live).sleep.asleep || ring(*live).rebuilt);
    }
    bool refined = false;
    while (live->is_comparing(1) && !ring(*live).rebuilt && steady_clock::now() < hung) {
      gate.release_current();
      refined = live->advance(0.002).refined || refined;
    }
    EXPECT_TRUE(refined || !ring(*live).rebuilt);
  }
  EXPECT_GE(steps_to_last_commit(*live), kHeldSteps);
  EXPECT_EQ(genus_of(ring(*live).mesh), 1);
  EXPECT_FALSE(ring(*live).sleep.asleep);
  expect_same_replayed_comparisons(*live);
  gate.release_all();
  bool at_rest = false;
  ASSERT_TRUE(run_frames_until(*live, [&] { return at_rest = live->advance(0.002).at_rest; }));
  EXPECT_FALSE(live->is_comparing(1));
  EXPECT_TRUE(ring(*live).sleep.asleep);
  EXPECT_TRUE(compare_with_field(live->scene().meshes[0], ring_volume()).matches());
  expect_same_replayed_comparisons(*live);
}

TEST(FieldComparisons, PendingAtTheEndOfALogArePendingAfterTheReplay) {
  Gate gate;
  const auto live = open_ring();
  live->set_field_comparison(gate.holding());
  ASSERT_TRUE(run_frames_until(*live, [&] { return live->is_comparing(1); }));
  for (int frame = 0; frame < 20; ++frame) live->advance(0.002);
  // A refinement in these frames discards the comparison of the coarser mesh.
  ASSERT_TRUE(run_frames_until(*live, [&] { return live->is_comparing(1); }));
  expect_same_replayed_comparisons(*live);
  gate.release_all();
  // advance_steps() commits them before its first step and makes the next ones between two steps, without a log entry.
  const int starts = count_of<StartFieldComparison>(*live), commits = count_of<CommitFieldComparison>(*live);
  live->advance_steps(800);
  EXPECT_EQ(count_of<CommitFieldComparison>(*live), commits + 1);
  EXPECT_EQ(count_of<StartFieldComparison>(*live), starts);
  EXPECT_TRUE(ring(*live).rebuilt);
  expect_same_replayed_comparisons(*live);
}

TEST(FieldComparisons, AreMadeBetweenTwoStepsWithoutLogEntriesByAdvanceSteps) {
  const auto session = open_ring();
  session->set_field_comparison([](const MeshItem&, bool, const SimulationParameters&, const Volume&,
                                   const StopCheck&) -> FieldComparison { throw Error("compared in the background"); });
  const std::size_t commands = session->log().size();
  EXPECT_TRUE(session->advance_steps(2000, true).at_rest);
  EXPECT_TRUE(ring(*session).rebuilt);
  EXPECT_EQ(session->log().size(), commands);
}

TEST(FieldComparisons, AReplayInPartsGivesTheSameBits) {
  const auto live = open_ring();
  ASSERT_TRUE(run_frames_until(*live, [&] { return ring(*live).rebuilt; }));
  const auto again = open_ring();
  for (LogReplay replay(*again, live->log(), live->steps_since_last_command()); !replay.done();) {
    EXPECT_LE(replay.commands_done(), live->log().size());
    if (replay.steps_left() == 0)
      replay.execute_next();
    else
      EXPECT_LE(replay.advance(7).steps, 7);
  }
  EXPECT_TRUE(same_state(state_of(*again), state_of(*live)));
}

/// Session in which the comparison of the ring has been started and is held.
struct Comparing {
  Gate gate;
  std::unique_ptr<Session> session = open_ring();
  ItemId mesh = ring(*session).id;

  Comparing() {
    session->apply(EditMesh{mesh, "ring 1", {}, {}, {}});  // an action to undo
    session->set_field_comparison(gate.holding());
    EXPECT_TRUE(run_frames_until(*session, [&] { return session->is_comparing(mesh); }));
  }
};

TEST(FieldComparisons, AreDiscardedByWhatMakesThemUseless) {
  const std::vector<std::pair<const char*, std::function<void(Session&, ItemId)>>> useless = {
      {"deletion", [](Session& s, ItemId mesh) { s.apply(DeleteMesh{mesh}); }},
      {"lock",
       [](Session& s, ItemId mesh) {
         s.apply(EditMesh{mesh, {}, {}, {}, {}, true});
       }},
      {"reset", [](Session& s, ItemId mesh) { s.apply(ResetPose{mesh}); }},
      {"reset of all", [](Session& s, ItemId) { s.apply(ResetPose{0}); }},
      {"refinement", [](Session& s, ItemId mesh) { s.apply(RefineMesh{mesh}); }},
      {"undo", [](Session& s, ItemId) { s.apply(Undo{}); }},
      {"redo", [](Session& s, ItemId) { s.apply(Redo{}); }},
      {"another source of evidence",
       [](Session& s, ItemId mesh) {
         s.apply(SetForceParameter{mesh, ForceId::Evidence, parameter_index("evidence", "source"), 1});
       }},
      {"no evidence",
       [](Session& s, ItemId mesh) {
         s.apply(SetForceParameter{mesh, ForceId::Evidence, parameter_index("evidence", "weight"), 0});
       }},
      {"another field",
       [](Session& s, ItemId mesh) {
         s.apply(AddPoint{mesh, {0, 0, 12}, MarkKind::Outside, 2});
         s.apply(StartFieldUpdate{mesh});
         EXPECT_TRUE(s.is_comparing(mesh)) << "the mark alone does not change the field";
         s.apply(CommitFieldUpdate{});
       }},
  };
  for (const auto& [what, act] : useless) {
    Comparing comparing;
    Session& live = *comparing.session;
    act(live, comparing.mesh);
    EXPECT_FALSE(live.is_comparing(comparing.mesh)) << what;
    EXPECT_EQ(live.scene().meshes.empty() || !ring(live).rebuilt, true) << what;
    comparing.gate.release_all();
    const int commits = count_of<CommitFieldComparison>(live);
    live.advance_steps(15);
    EXPECT_EQ(count_of<CommitFieldComparison>(live), commits) << what;
    expect_same_replayed_comparisons(live);
  }
}

TEST(FieldComparisons, ASettledMeshDoesNotSleepBeforeItsComparisonIsCommitted) {
  Comparing comparing;
  Session& live = *comparing.session;
  const auto is_settled = [&] {
    return live.mean_move_mm()[0] <
           live.scene_without_poses().simulation.rest_tolerance_voxels * voxel_mm(ring_volume());
  };
  ASSERT_TRUE(run_frames_until(live, [&] { return live.is_comparing(comparing.mesh) && is_settled(); }));
  const std::int64_t steps = live.total_steps();
  while (live.total_steps() < steps + 100) {
    ASSERT_FALSE(live.advance(0.002).at_rest);
    ASSERT_FALSE(ring(live).sleep.asleep);
  }
  EXPECT_TRUE(live.is_comparing(comparing.mesh));
  expect_same_replayed_comparisons(live);
}

TEST(FieldComparisons, AreKeptByOtherActions) {
  Comparing comparing;
  Session& live = *comparing.session;
  const ItemId mesh = comparing.mesh;
  live.apply(EditMesh{mesh, "renamed", Colour{1, 2, 3}, false, 7, {}, 0.5f});
  live.apply(AddPoint{mesh, {14, 5, 0}, MarkKind::Boundary});
  live.apply(SetForceParameter{mesh, ForceId::Smoothing, 0, 1.5f});
  const ItemId copy = live.apply(DuplicateMesh{mesh});
  live.apply(ReorderMesh{mesh, 1});
  EXPECT_TRUE(live.is_comparing(mesh));
  EXPECT_FALSE(live.is_comparing(copy));
  live.apply(DeleteMesh{copy});
  live.advance(0.002);
  EXPECT_TRUE(live.is_comparing(mesh));
  comparing.gate.release_all();
  ASSERT_TRUE(run_frames_until(live, [&] { return live.scene_without_poses().find_mesh(mesh)->rebuilt; }));
  const MeshItem& item = *live.scene().find_mesh(mesh);
  EXPECT_EQ(item.name, "renamed");
  EXPECT_EQ(item.label, 7);
  EXPECT_FALSE(item.visible);
  EXPECT_EQ(item.parameters.weight(ForceId::Smoothing), 1.5f);
  expect_same_replayed_comparisons(live);
}

TEST(FieldComparisons, ARebuiltMeshIsWokenAndTheRunIsNotSettledBefore) {
  Gate gate;
  const auto session = open_ring();
  ASSERT_TRUE(session->advance_steps(2000, true).at_rest);
  const ItemId mesh = ring(*session).id;
  session->set_field_comparison(gate.holding([](const MeshItem& item, bool, const SimulationParameters& simulation,
                                                const Volume& image, const StopCheck& check_stop) {
    return FieldComparison{{item.field, 0, true}, surface_of_field(item, simulation, image, check_stop)};
  }));
  session->apply(StartFieldComparison{mesh});
  for (int frame = 0; frame < 3; ++frame) EXPECT_FALSE(session->advance(0.002).at_rest);
  EXPECT_TRUE(ring(*session).sleep.asleep);
  const Positions before = session->scene().meshes[0].mesh.positions;
  gate.release_all();
  const auto hung = steady_clock::now() + kHung;
  bool refined = false;
  while (session->is_comparing(mesh) && steady_clock::now() < hung) refined = session->advance(0.002).refined;
  EXPECT_TRUE(refined);
  EXPECT_FALSE(same_bits(session->scene().meshes[0].mesh.positions, before));
  bool at_rest = false;
  EXPECT_TRUE(run_frames_until(*session, [&] { return at_rest = session->advance(0.002).at_rest; }));
}

TEST(FieldComparisons, CommandsThatCannotBeExecuted) {
  Gate gate;
  const auto session = open_ring();
  const ItemId mesh = ring(*session).id, other = session->apply(AddMesh{"other", {{0, 0, 0}, 3}, std::nullopt});
  EXPECT_NE(refusal(*session, StartFieldComparison{other}).find("no complete field"), std::string::npos);
  EXPECT_NE(refusal(*session, StartFieldComparison{99}).find("there is none"), std::string::npos);
  session->set_field_comparison(gate.holding());
  session->apply(StartFieldComparison{mesh});
  EXPECT_NE(refusal(*session, StartFieldComparison{mesh}).find("compared already"), std::string::npos);
  session->apply(Undo{});
  const auto before = state_of(*session);
  session->apply(CommitFieldComparison{mesh});
  EXPECT_TRUE(same_state(state_of(*session), before)) << "it was discarded";
  EXPECT_FALSE(session->can_undo() && std::string(session->undo_title()).find("comparison") != std::string::npos);
}

TEST(FieldComparisons, NeitherTheEndOfASessionNorAnotherSceneWaitsForOne) {
  Comparing comparing;
  comparing.session->open(solved_ring_scene(), ring_volume());
  EXPECT_FALSE(comparing.session->is_comparing(comparing.mesh));
  comparing.session->advance_steps(200);
  comparing.session->apply(StartFieldComparison{comparing.mesh});
  comparing.session.reset();  // does not end if it waits, because the gate is closed
}

TEST(FieldComparisons, OfSeveralMeshesRunInTheOrderOfTheirStart) {
  const auto session = open_ring();
  MeshItem first = session->scene().meshes[0], second = first, third = first;
  second.id = 2, third.id = 3;
  Gate gate;
  std::vector<int> order;
  FieldComparer comparer;
  comparer.set_compare(gate.holding(
      [&](const MeshItem& item, bool settled, const SimulationParameters&, const Volume&, const StopCheck&) {
        order.push_back(static_cast<int>(item.id));
        return FieldComparison{{item.field, static_cast<int>(item.id), settled}, std::nullopt};
      }));
  const Scene& scene = session->scene();
  for (const MeshItem* item : {&first, &second, &third})
    comparer.start(*item, item->id == 3, scene.simulation, ring_volume());
  EXPECT_FALSE(comparer.ready());
  Scene without_second = scene;
  without_second.meshes = {first, third};
  comparer.discard_useless(without_second, ring_volume());
  EXPECT_FALSE(comparer.is_comparing(2));
  EXPECT_EQ(comparer.first_mesh(), 1u);
  gate.release_all();
  const FieldComparison of_third = comparer.finish(3);
  EXPECT_EQ(of_third.fit.disagreement, 3);
  EXPECT_TRUE(of_third.fit.settled);
  EXPECT_EQ(of_third.fit.field, first.field) << "the field is shared, not copied";
  EXPECT_TRUE(comparer.ready());
  EXPECT_EQ(comparer.finish(1).fit.disagreement, 1);
  EXPECT_EQ(comparer.first_mesh(), 0u);
  EXPECT_EQ(order, (std::vector<int>{1, 3}));
}

}  // namespace
}  // namespace simplexseg
