// SPDX-License-Identifier: Apache-2.0
// An engine call that fails for lack of memory changes nothing.
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <new>
#include <utility>

#include "core/error.h"
#include "support/engine_fixture.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SIMPLEXSEG_OWN_ALLOCATOR  // the sanitizer's allocator ends the program when memory is exhausted
#endif

namespace simplexseg {
namespace {

/// Limits new allocations to `bytes` during its lifetime. Memory freed before is not available for reuse.
class MemoryLimit {
 public:
  explicit MemoryLimit(std::size_t bytes) {
    getrlimit(RLIMIT_AS, &before_);
    limit(0);
    for (std::size_t size = std::size_t{1} << 22; size >= std::size_t{1} << 13; size /= 2)
      while (auto* block = static_cast<Block*>(std::malloc(size))) blocks_ = new (block) Block{blocks_};
    limit(bytes);
  }
  ~MemoryLimit() {
    setrlimit(RLIMIT_AS, &before_);
    while (blocks_ != nullptr) std::free(std::exchange(blocks_, blocks_->next));
  }
  MemoryLimit(const MemoryLimit&) = delete;
  MemoryLimit& operator=(const MemoryLimit&) = delete;

 private:
  struct Block {
    Block* next;
  };
  void limit(std::size_t bytes) const {
    std::size_t pages = 0;
    if (std::FILE* const file = std::fopen("/proc/self/statm", "r")) {
      if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
      std::fclose(file);
    }
    rlimit new_limit = before_;
    new_limit.rlim_cur = pages * 4096 + bytes;
    setrlimit(RLIMIT_AS, &new_limit);
  }
  rlimit before_{};
  Block* blocks_ = nullptr;
};

/// True if `call` fails for lack of memory with `bytes` available.
template <class Call>
bool is_refused(std::size_t bytes, const Call& call) {
  const MemoryLimit limit(bytes);
  try {
    call();
  } catch (const Error&) {
    return true;
  } catch (const std::bad_alloc&) {
    return true;
  }
  return false;
}

TestScene with_internal_forces(int level) {
  TestScene scene = busy_scene(level);
  scene.meshes[0].forces = with({{"smoothing", "weight", 0.4f}});
  scene.points.clear();
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}
ForceParameters all_forces() {
  return with({{"smoothing", "weight", 0.4f},
               {"shape_memory", "weight", 0.1f},
               {"gradient", "weight", 0.2f},
               {"intensity_profile", "weight", 0.2f},
               {"evidence", "weight", 0.2f},
               {"evidence", "source", 1},
               {"evidence", "local", 0.5f},
               {"attraction", "weight", 0.5f}});
}

/// Repeats a call with more and more memory until it succeeds; after each refusal the engine must continue like one
/// without the call. Returns the number of refusals.
template <class Call>
int refusals(const TestScene& scene, const Call& call) {
  const auto refused = make_cpu_engine(1), other = make_cpu_engine(1);
  for (Engine* engine : {refused.get(), other.get()}) load(*engine, scene), engine->step(7);
  int count = 0;
  for (std::size_t bytes = 0; bytes < (std::size_t{1} << 28); bytes += std::size_t{1} << 19) {
    if (!is_refused(bytes, [&] { call(*refused); })) break;
    ++count;
    EXPECT_EQ(refused->bytes_allocated(), other->bytes_allocated()) << bytes;
    refused->step(2), other->step(2);
    if (!same_bits(positions_of(*refused, scene), positions_of(*other, scene))) {
      ADD_FAILURE() << "it continued differently after a refusal with " << bytes << " bytes";
      break;
    }
  }
  EXPECT_FALSE(refused->step(3).failure.has_value());
  return count;
}

class OutOfMemory : public ::testing::Test {
 protected:
  void SetUp() override {
#ifdef SIMPLEXSEG_OWN_ALLOCATOR
    GTEST_SKIP() << "skipped: the sanitizer's allocator ends the program";
#endif
  }
};

TEST_F(OutOfMemory, AFailedLoadKeepsThePreviousMeshes) {
  TestScene small = with_internal_forces(4), large = with_internal_forces(6);
  small.meshes[0].forces = large.meshes[0].forces = all_forces();
  small.points = {{0, {23.1, 2.2, 1.3}}};
  const std::vector<EngineMesh> meshes = engine_meshes(large);
  EXPECT_GT(refusals(small, [&](Engine& engine) { engine.load(meshes, large.simulation); }), 5);
}

TEST_F(OutOfMemory, FailedParametersKeepThePreviousOnes) {
  const TestScene scene = with_internal_forces(6);
  SimulationParameters multigrid = scene.simulation;
  multigrid.solver_choice = static_cast<float>(Solver::Multigrid);
  const std::vector<ForceParameters> all{all_forces()};
  EXPECT_GT(refusals(scene, [&](Engine& engine) { engine.set_parameters(all, multigrid); }), 3);
  SimulationParameters areas = scene.simulation;
  areas.solver_choice = static_cast<float>(Solver::Verlet), areas.area_in_mass = 0.5f;
  EXPECT_GT(refusals(scene, [&](Engine& engine) { engine.set_parameters(all, areas); }), 3);
}

TEST_F(OutOfMemory, FailedPointsKeepThePreviousOnes) {
  TestScene scene = with_internal_forces(6);
  weight_of(scene.meshes[0].forces, ForceId::Attraction) = 0.5f;
  for (int before : {0, 2}) {
    scene.points.assign(before, {0, {23.1, 2.2, 1.3}});
    const std::vector<EnginePoint> more(2000, {0, {-4.2, -14.1, 9.7}});
    EXPECT_GT(refusals(scene, [&](Engine& engine) { engine.set_points(more); }), 2) << before;
  }
}

TEST_F(OutOfMemory, AFailedFieldKeepsThePreviousOne) {
  TestScene scene = with_internal_forces(4);
  scene.meshes[0].forces =
      with({{"smoothing", "weight", 0.4f}, {"evidence", "weight", 0.5f}, {"evidence", "source", 0}});
  const std::vector<std::uint16_t> other = ball_field(scene.volume.geometry(), {-2, 1, 0}, kPhantomRadius - 3);
  const EngineField field{kVoxelCells, {{0, 0, 0}, scene.volume.geometry().size}, other};
  EXPECT_GT(refusals(scene, [&](Engine& engine) { engine.set_field(0, field); }), 0);
}

}  // namespace
}  // namespace simplexseg
