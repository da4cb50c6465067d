// SPDX-License-Identifier: Apache-2.0
// Time of the steps of a session in which several objects deform at once, as in the window.
//   bench_live [cpu|cuda] [SIZE] [OBJECTS] [SECONDS]
// The volume has SIZE x SIZE x SIZE voxels of 0.7 mm and OBJECTS ellipsoids in noise, each with a seed. Frames of 16 ms
// run until all meshes have settled or SECONDS are over, then an outside mark corrects the first object. Prints for
// both parts: seconds until all fields were solved and until all meshes had settled, frames above 25 ms and the longest
// one, steps, microseconds per step, bytes read back, and meshes that are folded.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <thread>

#include "core/freed_memory.h"
#include "gpu/backend.h"
#include "session/session.h"

using namespace simplexseg;

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

struct Ellipsoid {
  Eigen::Vector3d centre_mm, radii_mm;
  double value;
};

/// Ellipsoids in two layers, of two sizes and intensities.
std::vector<Ellipsoid> ellipsoids(int count, double extent_mm) {
  std::vector<Ellipsoid> all;
  const int across = static_cast<int>(std::ceil(std::sqrt(count / 2.0)));
  const double pitch = extent_mm / across;
  for (int n = 0; n < count; ++n) {
    const int layer = n % 2, place = n / 2;
    const double scale = 0.3 + 0.12 * (n % 3);
    const Eigen::Vector3d centre((place % across + 0.5) * pitch, (place / across + 0.5) * pitch,
                                 (layer + 0.5) * extent_mm / 2);
    all.push_back({centre, scale * pitch * Eigen::Vector3d(1, 0.8, 0.7), 60.0 + 40 * (n % 2)});
  }
  return all;
}

Volume volume_of(const std::vector<Ellipsoid>& objects, int size, double spacing_mm) {
  VolumeGeometry geometry;
  geometry.size = {size, size, size};
  geometry.spacing_mm = Eigen::Vector3d::Constant(spacing_mm);
  Volume image(geometry, VoxelType::Int16);
  const std::span<std::int16_t> voxels = image.voxels<std::int16_t>();
  std::uint64_t state = 1;
  std::size_t v = 0;
  for (int k = 0; k < size; ++k)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i, ++v) {
        const Eigen::Vector3d p = spacing_mm * Eigen::Vector3d(i, j, k);
        double value = 0;
        for (const Ellipsoid& one : objects)
          if (((p - one.centre_mm).array() / one.radii_mm.array()).square().sum() < 1) value = one.value;
        state = state * 6364136223846793005u + 1442695040888963407u;
        voxels[v] = static_cast<std::int16_t>(value + 12 * (static_cast<double>(state >> 40) * 0x1.0p-24 - 0.5) * 3.46);
      }
  return image;
}

bool fields_solved(const Session& session) {
  const auto& meshes = session.scene_without_poses().meshes;
  return session.solving_mesh() == 0 &&
         std::all_of(meshes.begin(), meshes.end(), [](const MeshItem& item) { return item.has_field(); });
}

/// Runs frames until all meshes have settled.
void run(Session& session, const char* name, double most_seconds) {
  constexpr double kFrame = 0.016, kBudget = 0.010, kLongFrame = 0.025;
  const std::uint64_t bytes = session.engine().bytes_read_back();
  const Clock::time_point start = Clock::now();
  double solved = 0, settled = 0, longest = 0, in_steps = 0;
  long steps = 0;
  int long_frames = 0;
  while (seconds_since(start) < most_seconds) {
    const Clock::time_point frame = Clock::now();
    const Advance done = session.advance(kBudget);
    const double seconds = seconds_since(frame);
    longest = std::max(longest, seconds);
    long_frames += seconds > kLongFrame;
    steps += done.steps;
    in_steps += done.seconds;
    if (solved == 0 && fields_solved(session)) solved = seconds_since(start);
    if (done.at_rest && fields_solved(session)) {
      settled = seconds_since(start);
      break;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(std::max(0.0, kFrame - seconds)));
  }
  int folded = 0, vertices = 0;
  for (const int n : session.last_outcome().folded_vertices) folded += n > 0;
  for (const MeshItem& item : session.scene_without_poses().meshes) vertices += item.mesh.vertex_count();
  std::printf("| %s | %d | %.2f | %.2f | %d | %.0f | %ld | %.0f | %.1f | %d |\n", name, vertices, solved, settled,
              long_frames, 1e3 * longest, steps, 1e6 * in_steps / static_cast<double>(std::max(1L, steps)),
              1e-6 * static_cast<double>(session.engine().bytes_read_back() - bytes), folded);
  std::fflush(stdout);
}

}  // namespace

int main(int count, char** arguments) {
  keep_freed_memory();  // as in the programs
  const Backend backend = count > 1 && std::string(arguments[1]) == "cuda" ? Backend::Cuda : Backend::Cpu;
  const int size = count > 2 ? std::atoi(arguments[2]) : 300, objects = count > 3 ? std::atoi(arguments[3]) : 8;
  const double seconds = count > 4 ? std::atof(arguments[4]) : 40;
  constexpr double kSpacing = 0.7;
  const std::vector<Ellipsoid> all = ellipsoids(objects, kSpacing * size);
  EngineChoice choice = make_engine(backend);
  Session session(std::move(choice.engine));
  session.set_field_solver(choice.fields);
  Scene scene;
  scene.simulation = default_simulation_parameters();
  session.open(std::move(scene), volume_of(all, size, kSpacing));
  std::printf(
      "| part | vertices | fields solved, s | settled, s | frames above 25 ms | longest, ms | steps | step, us | read "
      "back, MB | folded |\n|---|---|---|---|---|---|---|---|---|---|\n");
  for (const Ellipsoid& one : all)
    session.apply(AddMesh{"", {one.centre_mm, 0.6 * one.radii_mm.minCoeff()}, {}, 0, {}});
  run(session, "seeds", seconds);
  const Ellipsoid& first = all.front();
  session.apply(AddPoint{session.scene().meshes.front().id,
                         first.centre_mm + Eigen::Vector3d(0.9 * first.radii_mm.x(), 0, 0), MarkKind::Outside,
                         5 * kSpacing, Eigen::Vector3d::Zero()});
  run(session, "correction", seconds);
}
