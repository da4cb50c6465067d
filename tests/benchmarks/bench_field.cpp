// SPDX-License-Identifier: Apache-2.0
// Time and memory of an update of the evidence field after a click.
//   bench_field [THREADS|cuda] [SIZE...]
// The volume has SIZE voxels along each side, and two touching balls in noise. Prints a table: milliseconds of the
// update after the seed and after clicks (median, largest); bytes per voxel of the box that the field holds between
// updates, and by which the host's memory grows at most during an update; Dice after the last click.
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <string>
#include <vector>

#include "core/freed_memory.h"
#include "core/thread_pool.h"
#include "field/evidence_field.h"
#include "field/robot_user.h"
#include "gpu/backend.h"

using namespace simplexseg;

// Bytes allocated by the program, and their largest number since the last reset.
static std::atomic<std::size_t> in_use{0}, most_in_use{0};

static void* counted_pointer(void* at) {
  if (!at) throw std::bad_alloc();
  const std::size_t now = in_use += malloc_usable_size(at);
  for (std::size_t most = most_in_use; most < now && !most_in_use.compare_exchange_weak(most, now);) {
  }
  return at;
}
static void count_and_free(void* at) {
  in_use -= malloc_usable_size(at);
  std::free(at);
}
void* operator new(std::size_t bytes) { return counted_pointer(std::malloc(bytes)); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  const auto multiple = static_cast<std::size_t>(alignment);
  return counted_pointer(std::aligned_alloc(multiple, (bytes + multiple - 1) / multiple * multiple));
}
void operator delete(void* at) noexcept { count_and_free(at); }
void operator delete(void* at, std::size_t) noexcept { count_and_free(at); }
void operator delete(void* at, std::align_val_t) noexcept { count_and_free(at); }
void operator delete(void* at, std::size_t, std::align_val_t) noexcept { count_and_free(at); }

namespace {

/// Image and mask of a ball that touches another one of the same intensity, with noise of a quarter of the contrast, so
/// that clicks are needed.
std::pair<Volume, Mask> touching_balls(int size) {
  VolumeGeometry geometry;
  geometry.size = {size, size, size};
  Volume image(geometry, VoxelType::Float32);
  Mask truth{geometry, std::vector<std::uint8_t>(geometry.voxel_count())};
  const std::span<float> voxels = image.voxels<float>();
  const double s = size, radius = 0.24 * s;
  std::uint64_t state = 1;
  std::size_t v = 0;
  for (int k = 0; k < size; ++k)
    for (int j = 0; j < size; ++j)
      for (int i = 0; i < size; ++i, ++v) {
        const Eigen::Vector3d p(i, j, k);
        const bool in = (p - Eigen::Vector3d(0.36 * s, 0.5 * s, 0.5 * s)).norm() < radius;
        const bool in_other = (p - Eigen::Vector3d(0.78 * s, 0.5 * s, 0.5 * s)).norm() < 0.8 * radius;
        truth.voxels[v] = in;
        double noise = -6;
        for (int n = 0; n < 12; ++n) {
          state = state * 6364136223846793005u + 1442695040888963407u;
          noise += static_cast<double>(state >> 40) * 0x1.0p-24;
        }
        voxels[v] = static_cast<float>(100 * (in || in_other) + 25 * noise);
      }
  return {std::move(image), std::move(truth)};
}

class Timed : public RobotSubject {
 public:
  Timed(const Volume& image, RunJobs run, const MakeFieldSolver& make) : field_(image, std::move(run), {}, make) {}
  Mask segment(std::span<const Mark> marks) override {
    const std::size_t before = most_in_use = in_use.load();
    const auto start = std::chrono::steady_clock::now();
    field_.update(marks);
    ms_.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
    most_bytes_ = std::max(most_bytes_, most_in_use - before);
    return field_.object();
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return field_.brush_mm(kind, mm); }
  const std::vector<double>& ms() const { return ms_; }
  const EvidenceField& field() const { return field_; }
  std::size_t most_bytes() const { return most_bytes_; }

 private:
  EvidenceField field_;
  std::vector<double> ms_;
  std::size_t most_bytes_ = 0;
};

}  // namespace

int main(int count, char** arguments) {
  keep_freed_memory();  // as in the programs
  const bool on_device = count > 1 && std::string(arguments[1]) == "cuda";
  const int threads = count > 1 && !on_device ? std::atoi(arguments[1]) : 2;
  const MakeFieldSolver make = on_device ? make_cuda_field_solver : make_cpu_field_solver;
  std::vector<int> sizes{64, 128};
  if (count > 2) {
    sizes.clear();
    for (int a = 2; a < count; ++a) sizes.push_back(std::atoi(arguments[a]));
  }
  ThreadPool pool(std::max(1, threads));
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  std::printf(
      "| box | seed ms | click ms, median | largest | bytes per voxel | peak of an update | Dice "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const int size : sizes) {
    const auto [image, truth] = touching_balls(size);
    Timed subject(image, run, make);
    RobotSettings robot;
    robot.most_clicks = 10;
    const std::vector<RobotClick> clicks = run_robot(truth, subject, robot, [](int, const Mask&) {});
    std::vector<double> ms(subject.ms().begin() + 1, subject.ms().end());
    if (ms.empty()) ms.push_back(0);
    std::sort(ms.begin(), ms.end());
    const VoxelBox& box = subject.field().box();
    std::printf("| %d x %d x %d | %.1f | %.1f | %.1f | %.1f | %.1f | %.3f |\n", box.size[0], box.size[1], box.size[2],
                subject.ms().front(), ms[ms.size() / 2], ms.back(),
                static_cast<double>(subject.field().bytes()) / static_cast<double>(box.voxel_count()),
                static_cast<double>(subject.most_bytes()) / static_cast<double>(box.voxel_count()),
                clicks.back().agreement.dice);
    std::fflush(stdout);
  }
}
