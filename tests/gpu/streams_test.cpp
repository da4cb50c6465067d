// SPDX-License-Identifier: Apache-2.0
// Engines that run concurrently in several threads on one device.
#include <thread>

#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

using Streams = EngineTest;
SIMPLEXSEG_ON_EVERY_BACKEND(Streams);

TEST_P(Streams, ConcurrentEnginesGiveTheSameBitsAsAlone) {
  constexpr int kThreads = 6, kRounds = 3;
  std::vector<TestScene> scenes;
  std::vector<Positions> alone, concurrent(kThreads);
  for (int n = 0; n < kThreads; ++n) {
    TestScene scene = busy_scene(2 + n % 3);
    ForceParameters& forces = scene.meshes[0].forces;
    weight_of(forces, ForceId::Smoothing) = 0.3f + 0.1f * static_cast<float>(n);
    weight_of(forces, ForceId::Gradient) = 0.5f, weight_of(forces, ForceId::Attraction) = 1;
    // Needs more shared memory than the default limit of a block, a different amount for each engine.
    set(forces, {"gradient", "samples", static_cast<float>(8 + 4 * (n % 3))});
    scenes.push_back(std::move(scene));
    alone.push_back(run(scenes.back(), 60));
  }
  EXPECT_FALSE(same_bits(alone[0], alone[3])) << "the scenes must differ";
  for (int round = 0; round < kRounds; ++round) {
    std::vector<std::jthread> threads;
    for (int n = 0; n < kThreads; ++n)
      threads.emplace_back([&, n] {
        const DeviceStream stream;
        const auto engine = make_engine();
        load(*engine, scenes[static_cast<std::size_t>(n)]);
        for (int batch = 0; batch < 6; ++batch) engine->step(10);
        concurrent[static_cast<std::size_t>(n)] = positions_of(*engine, scenes[static_cast<std::size_t>(n)]);
      });
    threads.clear();
    for (int n = 0; n < kThreads; ++n)
      EXPECT_TRUE(same_bits(alone[static_cast<std::size_t>(n)], concurrent[static_cast<std::size_t>(n)])) << n;
  }
}

}  // namespace
}  // namespace simplexseg
