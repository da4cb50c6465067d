// SPDX-License-Identifier: Apache-2.0
// Devices that fail or run out of memory: the session continues on the fallback engine, or throws without losing data.
#include "core/error.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

/// CPU engine that simulates a failing device.
class Device : public Engine {
 public:
  struct State {
    bool fails = false, full = false;  ///< full: out of memory, every load fails
    std::size_t bytes = std::size_t{1} << 40;
  };
  explicit Device(std::shared_ptr<State> state) : state_(std::move(state)) {}
  const char* backend() const override { return "cuda"; }
  std::string description() const override { return "test device"; }
  void set_volume(const Volume& volume) override { inner().set_volume(volume); }
  void load(std::span<const EngineMesh> meshes, const SimulationParameters& s,
            std::span<const EnginePoint> points) override {
    if (state_->full) throw Error("mesh arrays", "there is not enough memory", "use fewer or coarser meshes");
    inner().load(meshes, s, points);
  }
  void set_parameters(std::span<const ForceParameters> meshes, const SimulationParameters& s,
                      std::span<const char> finest) override {
    inner().set_parameters(meshes, s, finest);
  }
  void set_points(std::span<const EnginePoint> points) override { inner().set_points(points); }
  void set_asleep(std::span<const char> meshes) override { inner().set_asleep(meshes); }
  void set_field(int mesh, const EngineField& field) override { inner().set_field(mesh, field); }
  void set_fixed_targets(int mesh, ForceId force, std::span<const Vec4> targets) override {
    inner().set_fixed_targets(mesh, force, targets);
  }
  void read_targets(int mesh, ForceId force, std::span<Vec4> targets) override {
    inner().read_targets(mesh, force, targets);
  }
  void refresh() override { inner().refresh(); }
  StepOutcome step(int count) override { return inner().step(count); }
  void read(int mesh, std::span<Eigen::Vector3f> positions, std::span<Eigen::Vector3f> previous) override {
    inner().read(mesh, positions, previous);
  }
  std::unique_ptr<SharedBuffer> share_buffer(unsigned, std::size_t) override { return nullptr; }
  void set_cells(std::span<const CellList* const> cells) override { inner().set_cells(cells); }
  bool has_cells() const override { return engine_->has_cells(); }
  void draw_surfaces(DrawTarget<DisplayPoint> target) override { inner().draw_surfaces(target); }
  void draw_outlines(int axis, float position_mm, DrawTarget<std::byte> target) override {
    inner().draw_outlines(axis, position_mm, target);
  }
  void draw_slice(const SlicePlane& plane, DrawTarget<DisplayTexel> target) override {
    inner().draw_slice(plane, target);
  }
  std::uint64_t bytes_read_back() const override { return 0; }
  std::size_t bytes_available() const override { return state_->bytes; }
  std::size_t bytes_allocated() const override { return engine_->bytes_allocated(); }
  std::vector<AllocatedArray> allocated_arrays() const override { return engine_->allocated_arrays(); }
  std::vector<KernelCount> kernel_counts() const override { return engine_->kernel_counts(); }

 private:
  Engine& inner() {
    if (state_->fails) throw DeviceError("CUDA: a kernel", "the device was lost", "use --backend cpu");
    return *engine_;
  }
  std::shared_ptr<State> state_;
  std::unique_ptr<Engine> engine_ = make_cpu_engine(1);
};

Scene scene_of_one() {
  Scene scene;
  MeshItem item;
  item.name = "ball", item.seed = {{0, 0, 0}, 12};
  item.parameters = default_force_parameters();
  set(item.parameters, {"evidence", "source", 1});  // no field: comparing the mesh with it would read poses
  scene.meshes.push_back(item);
  scene.simulation = default_simulation_parameters();
  return scene;
}

struct Failover : ::testing::Test {
  std::shared_ptr<Device::State> device = std::make_shared<Device::State>();
  Volume volume = phantom("sphere").image;
  Session with_fallback{std::make_unique<Device>(device), [] { return make_cpu_engine(1); }};
  Session without{std::make_unique<Device>(device)};
};

TEST_F(Failover, StepsContinueOnTheFallbackEngine) {
  with_fallback.open(scene_of_one(), volume);
  with_fallback.advance_steps(20);
  const Positions before = with_fallback.scene().meshes[0].mesh.positions;
  device->fails = true;
  const Advance advance = with_fallback.advance_steps(10);
  EXPECT_EQ(advance.steps, 10);
  EXPECT_STREQ(with_fallback.engine().backend(), "cpu");
  EXPECT_EQ(with_fallback.engine_generation(), 1);
  const std::optional<std::string> notice = with_fallback.pop_notice();
  ASSERT_TRUE(notice.has_value());
  EXPECT_NE(notice->find("the device was lost"), std::string::npos) << *notice;
  EXPECT_FALSE(with_fallback.pop_notice().has_value()) << "a notice is returned only once";
  EXPECT_GT(largest_distance(with_fallback.scene().meshes[0].mesh.positions, before), 1e-3) << "the mesh must move";
}

TEST_F(Failover, CommandsAreNotLost) {
  with_fallback.open(scene_of_one(), volume);
  device->fails = true;
  const ItemId point = with_fallback.apply(AddPoint{with_fallback.scene().meshes[0].id, {15, 0, 0}});
  EXPECT_NE(point, 0u);
  EXPECT_EQ(with_fallback.scene().points.size(), 1u);
  EXPECT_STREQ(with_fallback.engine().backend(), "cpu");
  with_fallback.apply(MovePoint{point, {16, 0, 0}, true});
  EXPECT_EQ(with_fallback.scene().points[0].position_mm[0], 16);
}

TEST_F(Failover, ContinuesFromPosesReadLast) {
  with_fallback.open(scene_of_one(), volume);
  with_fallback.advance_steps(20);
  device->fails = true;
  EXPECT_EQ(with_fallback.scene().meshes[0].mesh.positions.size(), with_fallback.scene().meshes[0].previous.size());
  with_fallback.advance_steps(1);
  const std::optional<std::string> notice = with_fallback.pop_notice();
  ASSERT_TRUE(notice.has_value());
  EXPECT_NE(notice->find("20 steps ago"), std::string::npos) << *notice;
}

TEST_F(Failover, SolverStateBelongsToThePose) {
  Scene scene = scene_of_one();
  // Prevents refinement, which would read the pose and reset the solver.
  scene.simulation.final_vertices = scene.simulation.start_vertices;
  with_fallback.open(scene, volume);
  with_fallback.advance_steps(40);
  const SolverState early = with_fallback.last_outcome().solver.at(0);
  ASSERT_GT(early.min_eigenvalue, 0);
  EXPECT_EQ(with_fallback.scene_without_poses().meshes[0].solver.min_eigenvalue, 0) << "not read back yet";
  EXPECT_EQ(with_fallback.scene().meshes[0].solver.min_eigenvalue, early.min_eigenvalue);
  with_fallback.advance_steps(40);
  ASSERT_NE(with_fallback.last_outcome().solver.at(0).min_eigenvalue, early.min_eigenvalue);
  device->fails = true;
  EXPECT_EQ(with_fallback.scene().meshes[0].solver.min_eigenvalue, early.min_eigenvalue)
      << "solver state at the pose that was read last";
}

TEST_F(Failover, EditsUsePosesReadLast) {
  with_fallback.open(scene_of_one(), volume);
  with_fallback.advance_steps(20);
  (void)with_fallback.scene();
  const int vertices = with_fallback.scene().meshes[0].mesh.vertex_count();
  with_fallback.advance_steps(7);
  device->fails = true;
  with_fallback.apply(RefineMesh{0});
  EXPECT_STREQ(with_fallback.engine().backend(), "cpu");
  EXPECT_EQ(with_fallback.scene().meshes[0].mesh.vertex_count(), 4 * vertices);
  EXPECT_NE(with_fallback.pop_notice()->find("7 steps ago"), std::string::npos);
  with_fallback.apply(Undo{});
  EXPECT_EQ(with_fallback.scene().meshes[0].mesh.vertex_count(), vertices);
  EXPECT_EQ(with_fallback.advance_steps(5).steps, 5);
}

TEST_F(Failover, AReplacementOfAFailedEngineIsUsed) {
  with_fallback.open(scene_of_one(), volume);
  with_fallback.advance_steps(20);
  device->fails = true;
  (void)with_fallback.scene();  // detects the failure
  const auto other = std::make_shared<Device::State>();
  with_fallback.set_engine(std::make_unique<Device>(other));
  EXPECT_EQ(with_fallback.advance_steps(10).steps, 10);
  EXPECT_STREQ(with_fallback.engine().backend(), "cuda") << "the fallback is not needed";
}

TEST_F(Failover, WithoutAFallbackTheFailureIsThrown) {
  without.open(scene_of_one(), volume);
  device->fails = true;
  EXPECT_THROW(without.advance_steps(1), DeviceError);
  EXPECT_EQ(without.scene_without_poses().meshes.size(), 1u);
}

TEST_F(Failover, ARefinementWithoutMemoryIsNotStarted) {
  Scene scene = scene_of_one();
  scene.simulation.steps_per_level = 20;
  without.open(scene, volume);
  Session& session = without;
  session.advance_steps(11);
  const int vertices = session.scene().meshes[0].mesh.vertex_count();
  device->full = true;
  EXPECT_THROW(session.apply(RefineMesh{0}), Error);
  EXPECT_EQ(session.scene().meshes[0].mesh.vertex_count(), vertices);
  // Automatic refinement fails, too; the steps before it are executed.
  EXPECT_THROW(session.advance_steps(30), Error);
  EXPECT_EQ(session.total_steps(), 20);
  EXPECT_EQ(session.scene_without_poses().meshes[0].mesh.vertex_count(), vertices);
  EXPECT_EQ(session.scene_without_poses().meshes[0].steps_at_level, 20);
  const Positions before = session.scene().meshes[0].mesh.positions;
  EXPECT_EQ(session.advance_steps(5).steps, 5);
  EXPECT_GT(largest_distance(session.scene().meshes[0].mesh.positions, before), 0);
  device->full = false;
  EXPECT_TRUE(session.advance_steps(5).refined);
  EXPECT_EQ(session.scene().meshes[0].mesh.vertex_count(), 4 * vertices);
}

TEST_F(Failover, ASceneWithoutMemoryIsNotOpened) {
  without.open(scene_of_one(), volume);
  without.advance_steps(11);
  Scene larger = scene_of_one();
  larger.meshes[0].mesh = make_sphere({0, 0, 0}, 12, 4);
  device->full = true;
  EXPECT_THROW(without.open(larger, phantom("flat").image), Error);
  EXPECT_EQ(without.total_steps(), 11);
  EXPECT_EQ(without.volume().data(), volume.data());
  EXPECT_EQ(without.advance_steps(5).steps, 5);
  EXPECT_EQ(without.scene().meshes[0].mesh.vertex_count(), without.scene().meshes[0].previous.size());
  EXPECT_NE(without.scene().meshes[0].mesh.vertex_count(), larger.meshes[0].mesh.vertex_count());
}

TEST_F(Failover, TooLittleMemoryIsReportedWithBothFiguresBeforeLoading) {
  without.open(scene_of_one(), volume);
  device->bytes = 1 << 20;
  Scene larger = scene_of_one();
  larger.meshes[0].name = "another";
  std::string why;
  try {
    without.open(larger, volume);
  } catch (const Error& error) {
    why = error.what();
  }
  EXPECT_NE(why.find("1 MiB free"), std::string::npos) << why;
  EXPECT_NE(why.find("MiB needed"), std::string::npos) << why;
  EXPECT_EQ(without.scene().meshes[0].name, "ball") << "the previous scene stays open";
  without.advance_steps(5);
  with_fallback.open(larger, volume);
  EXPECT_STREQ(with_fallback.engine().backend(), "cpu");
  EXPECT_NE(with_fallback.pop_notice()->find("MiB needed"), std::string::npos);
}

}  // namespace
}  // namespace simplexseg
