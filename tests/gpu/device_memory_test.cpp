// SPDX-License-Identifier: Apache-2.0
// Device memory used by a large scene, compared with the size of its data.
#include <cstdio>

#include "core/error.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

TEST(DeviceMemory, ALargeSceneUsesLittleMoreMemoryThanItsData) {
  if (!cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  TestScene scene;
  VolumeGeometry geometry;
  geometry.size = {512, 512, 512};
  scene.volume = Volume(geometry, VoxelType::Int16);
  for (int k = 0; k < 10; ++k) {
    TestMesh m;
    m.mesh = make_sphere({50.0 * k, 200, 200}, 20, 5);
    m.forces = weightless();
    weight_of(m.forces, ForceId::Smoothing) = 0.5f, weight_of(m.forces, ForceId::Gradient) = 0.5f;
    weight_of(m.forces, ForceId::Evidence) = 0.5f, weight_of(m.forces, ForceId::Attraction) = 1;
    scene.meshes.push_back(m);
    scene.points.push_back({k, {50.0 * k + 25, 200, 200}});
  }
  make_cuda_engine()->step(1);  // one-time allocations of the first engine
  const auto warm = make_cuda_engine();
  load(*warm, busy_scene());
  warm->step(40);
  const std::size_t before = cuda_device()->bytes_free;
  const auto engine = make_cuda_engine();
  load(*engine, scene);
  engine->step(40);
  const std::size_t used = before - cuda_device()->bytes_free, data = engine->bytes_allocated();
  std::printf("[ memory ] %.1f MB of data, %.1f MB used\n", data * 1e-6, used * 1e-6);
  EXPECT_GT(data, std::size_t{512} * 512 * 512 * 2);
  EXPECT_LE(static_cast<double>(used), 1.15 * static_cast<double>(data));
}

TEST(DeviceMemory, AVolumeThatDoesNotFitIsRefusedWithBothFigures) {
  if (!cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  VolumeGeometry geometry;
  const std::size_t free = cuda_device()->bytes_free;
  geometry.size = {2048, 2048, static_cast<int>(free / (2048 * 2048 * 2)) + 10};
  Volume large;
  try {
    large = Volume(geometry, VoxelType::Int16);  // untouched pages
  } catch (const Error&) {
    GTEST_SKIP() << "skipped: the host lacks address space";
  }
  const auto engine = make_cuda_engine();
  try {
    engine->set_volume(large);
    FAIL() << "it was accepted";
  } catch (const DeviceError& error) {
    EXPECT_NE(std::string(error.what()).find("MiB do not fit into the"), std::string::npos) << error.what();
  }
  EXPECT_NEAR(static_cast<double>(cuda_device()->bytes_free), static_cast<double>(free), 64e6)
      << "nothing was allocated";
}

TEST(DeviceMemory, AVolumeThatDoesNotFitKeepsTheOldOne) {
  if (!cuda_unavailable_reason().empty())
    GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  TestScene scene = busy_scene();
  weight_of(scene.meshes[0].forces, ForceId::Smoothing) = weight_of(scene.meshes[0].forces, ForceId::Gradient) = 0.5f;
  const auto refused = make_cuda_engine(), other = make_cuda_engine();
  for (Engine* engine : {refused.get(), other.get()}) load(*engine, scene), engine->step(5);
  // Uses all free memory to the last slice, which the device reports but cannot allocate.
  VolumeGeometry geometry;
  geometry.size = {2048, 2048, static_cast<int>(cuda_device()->bytes_free / (2048 * 2048 * 2))};
  Volume large;
  try {
    large = Volume(geometry, VoxelType::Int16);  // untouched pages
  } catch (const Error&) {
    GTEST_SKIP() << "skipped: the host lacks address space";
  }
  try {
    refused->set_volume(large);
    GTEST_SKIP() << "skipped: the device could allocate all of its memory";
  } catch (const DeviceError&) {
  }
  for (Engine* engine : {refused.get(), other.get()}) engine->refresh(), engine->step(5);
  EXPECT_TRUE(same_bits(positions_of(*refused, scene), positions_of(*other, scene)));
}

}  // namespace
}  // namespace simplexseg
