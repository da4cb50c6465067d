// SPDX-License-Identifier: Apache-2.0
#include "evidence/parallel/prior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "ellipsoid_scene.h"
#include "evidence/evidence_field.h"
#include "evidence/seed_reach.h"

namespace simplexseg {
namespace {

/// SerialExecutor that counts operations that are slow on a device.
class Counting : public SerialExecutor {
 public:
  mutable int launches = 0, waits = 0, uploads = 0;

  template <class Kernel>
  void each(int n, const Kernel& kernel) const {
    ++launches;
    SerialExecutor::each(n, kernel);
  }
  template <class Kernel>
  void all(const Kernel& kernel) const {
    ++launches;
    SerialExecutor::all(kernel);
  }
  template <class Kernel>
  void teams(int count, const Kernel& kernel) const {
    ++launches;
    SerialExecutor::teams(count, kernel);
  }
  template <class Kernel>
  void sums_into(int n, const Kernel& kernel, double* to) const {
    ++launches;
    SerialExecutor::sums_into(n, kernel, to);
  }
  template <class Kernel>
  void histogram(int n, const Kernel& kernel, int* count) const {
    ++launches;
    SerialExecutor::histogram(n, kernel, count);
  }
  template <class T>
  void upload(std::span<const T> from, T* to) const {
    ++uploads;
    SerialExecutor::upload(from, to);
  }
  template <class T>
  void download(const T* from, std::span<T> to) const {
    ++waits;
    SerialExecutor::download(from, to);
  }
  template <class T>
  void receive(const Fetched<T>& fetched, std::span<T> to) const {
    ++waits;
    SerialExecutor::receive(fetched, to);
  }
  template <class T>
  void copy(const T* from, T* to, std::size_t count) const {
    ++launches;
    SerialExecutor::copy(from, to, count);
  }
  template <class T>
  void clear(T* at, std::size_t count) const {
    ++launches;
    SerialExecutor::clear(at, count);
  }
};

Mark boundary(const Eigen::Vector3d& at, double radius, const Eigen::Vector3d& outward) {
  return {MarkKind::Boundary, at, radius, outward};
}

/// Prompts of an object in a box: first marks, for which a field was solved, and new ones.
class Story {
 public:
  Story(const Volume& volume, std::vector<Mark> first, const std::vector<Mark>& then,
        const std::vector<Mark>& others = {})
      : volume_(volume), marks_(std::move(first)) {
    EvidenceField field(volume);
    field.update(marks_, others);
    box_ = field.box();
    if (!then.empty())
      for (const float p : field.probability()) before_.push_back(static_cast<std::uint8_t>(1.5f + 254 * p));
    for (const Mark& mark : then) add(mark);
    look(others);
  }
  /// Single seed in a separate box.
  Story(const VoxelBox& box, const Volume& volume, const Mark& seed) : volume_(volume), marks_{seed}, box_(box) {
    look({});
  }

  std::vector<std::uint8_t> computed_by_cpu(const EvidenceSettings& settings = {}) const {
    CoarsePrior prior(run_in_turn(), settings);
    prior.set_box(image_, volume_.geometry(), box_.first, reach_mm_);
    prior.learn({marks_, known_, before_, fresh_, reach_mm_, radius_mm_});
    std::vector<std::uint8_t> voxels(known_.size());
    prior.interpolate(smoothed_, kEdge, voxels);
    return voxels;
  }
  std::vector<std::uint8_t> open_by_cpu() const {
    CoarsePrior prior(run_in_turn(), {});
    prior.set_box(image_, volume_.geometry(), box_.first, reach_mm_);
    prior.learn({marks_, known_, before_, fresh_, reach_mm_, radius_mm_});
    std::vector<std::uint8_t> open(known_.size());
    prior.mark_open(known_, open);
    return open;
  }
  template <class Executor>
  ParallelPrior<Executor> parallel(const Executor& executor, const EvidenceSettings& settings = {}) const {
    ParallelPrior<Executor> prior(executor, settings, run_in_turn());
    prior.set_box(image_, volume_.geometry(), box_.first, reach_mm_);
    learn(prior);
    return prior;
  }
  template <class Executor>
  void learn(ParallelPrior<Executor>& prior) const {
    prior.learn({marks_, known_.data(), before_.empty() ? nullptr : before_.data(), fresh_, reach_mm_, radius_mm_});
  }
  template <class Executor>
  std::vector<std::uint8_t> voxels_of(const ParallelPrior<Executor>& prior) const {
    std::vector<std::uint8_t> voxels(known_.size());
    prior.interpolate(smoothed_.data(), kEdge, voxels.data());
    return voxels;
  }
  std::span<const Constraint> known() const { return known_; }

 private:
  static constexpr float kEdge = 0.02f;

  void look(std::span<const Mark> others) {
    image_ = cut_out(volume_, kVoxelCells, box_, run_in_turn());
    known_ = constraint_mask(volume_.geometry(), box_, image_.finite, marks_, others);
    const auto largest = std::max_element(marks_.begin(), marks_.end(),
                                          [](const Mark& a, const Mark& b) { return size_of(a) < size_of(b); });
    radius_mm_ = largest->radius_mm;
    reach_mm_ = seed_scale(volume_, largest->position_mm, largest->radius_mm).reach_mm;
    smoothed_ = image_.value;
    std::array<double, 3> spacing_mm;
    for (int a = 0; a < 3; ++a) spacing_mm[a] = volume_.geometry().spacing_mm[a];
    smooth_by_least_spacing(smoothed_, image_.grid, spacing_mm, 0.7, run_in_turn());
  }
  static double size_of(const Mark& mark) { return mark.kind == MarkKind::Outside ? 0 : mark.radius_mm; }
  void add(const Mark& mark) {
    marks_.push_back(mark);
    const Eigen::Vector3d step = ball_offset(mark);
    if (mark.kind != MarkKind::Outside) add_fresh(mark.position_mm - step, mark.radius_mm, true);
    if (mark.kind != MarkKind::Inside) add_fresh(mark.position_mm + step, mark.radius_mm, false);
  }
  void add_fresh(const Eigen::Vector3d& at, double radius_mm, bool inside) {
    const std::vector<float> square = squared_distances(volume_.geometry(), box_, {&at, 1}, run_in_turn());
    const auto nearest = std::min_element(square.begin(), square.end()) - square.begin();
    float least = 1e12f;
    for (std::size_t v = 0; v < square.size(); ++v)
      if ((before_[v] > kPreviousThreshold) != (before_[nearest] > kPreviousThreshold))
        least = std::min(least, square[v]);
    fresh_.push_back({at, radius_mm, inside, std::sqrt(least)});
  }

  Volume volume_;
  std::vector<Mark> marks_;
  VoxelBox box_;
  std::vector<std::uint8_t> before_;
  std::vector<NewMarkBall> fresh_;
  BoxImage image_;
  std::vector<float> smoothed_;
  std::vector<Constraint> known_;
  double radius_mm_, reach_mm_;
};

struct Difference {
  double mean = 0;
  int most = 0, far = 0;  ///< `far`: number of voxels that differ by more than 5
};
Difference difference(std::span<const std::uint8_t> a, std::span<const std::uint8_t> b) {
  Difference d;
  for (std::size_t v = 0; v < a.size(); ++v) {
    d.most = std::max(d.most, std::abs(a[v] - b[v]));
    d.far += std::abs(a[v] - b[v]) > 5;
    d.mean += std::abs(a[v] - b[v]) / static_cast<double>(a.size());
  }
  return d;
}

struct Named {
  std::string name;
  Story story;
};
std::vector<Named> stories() {
  std::vector<Named> all;
  const Scene noisy = ellipsoid(36, 1, {12, 10, 9}, 25), clean = ellipsoid(36, 1, {12, 10, 10}, 3),
              thick = ellipsoid(64, 4, {18, 14, 16}, 10), large = ellipsoid(64, 1, {24, 18, 20}, 20);
  const std::vector<Mark> seed{inside({0, 0, 0}, 8)};
  all.push_back({"noisy seed", Story(noisy.image, seed, {})});
  all.push_back({"noisy, outside", Story(noisy.image, seed, {outside({15, 0, 0}, 3)})});
  all.push_back({"noisy, inside and boundary",
                 Story(noisy.image, seed, {inside({9, 3, 1}, 2), boundary({0, 10, 0}, 2.5, {0, 1, 0})})});
  all.push_back({"clean seed", Story(clean.image, {inside({0, 0, 0}, 6)}, {})});
  all.push_back({"clean, contradicting",
                 Story(clean.image, {inside({0, 0, 0}, 6)}, {inside({0, 13, 0}, 2), outside({9, 0, 0}, 2)})});
  all.push_back({"thick slices", Story(thick.image, {inside({0, 0, 0}, 10)},
                                       {outside({20.3, 1, 0}, 2.7), boundary({0, 0, 16}, 3, {0.3, 0.1, 1})})});
  all.push_back({"large seed", Story(large.image, {inside({0.2, 0.1, 0}, 15)}, {})});
  all.push_back({"large, clicks", Story(large.image, {inside({0.2, 0.1, 0}, 15)},
                                        {outside({28, 0, 0}, 4), boundary({0, 18, 0}, 3, {0.1, 1, 0})})});
  {
    VolumeGeometry geometry = clean.image.geometry();
    geometry.direction << 1, 0.2, 0.1, 0, 1, 0.1, 0.1, 0, 1;
    geometry.spacing_mm = {0.7, 0.9, 1.3};
    Volume volume(geometry, VoxelType::Float32);
    std::copy_n(clean.image.voxels<float>().begin(), geometry.voxel_count(), volume.voxels<float>().begin());
    for (int v = 0; v < 1400; ++v) volume.voxels<float>()[v * 31] = std::numeric_limits<float>::quiet_NaN();
    const Eigen::Affine3d mm = geometry.world_from_index();
    all.push_back({"sheared, not finite, others", Story(volume, {inside(mm * Eigen::Vector3d(18, 18, 18), 4.9)},
                                                        {outside(mm * Eigen::Vector3d(18, 30, 19), 2.1),
                                                         boundary(mm * Eigen::Vector3d(18, 8, 18), 2.1, {0, -1, 0.2})},
                                                        {inside(mm * Eigen::Vector3d(32, 18, 18), 2.5)})});
  }
  {
    Scene cut = ellipsoid(40, 1, {26, 10, 10}, 10);  // cut by the volume
    all.push_back({"at the volume's edge", Story(cut.image, {inside({10, 0, 0}, 9)}, {inside({18, 1, 0}, 2)})});
  }
  return all;
}

TEST(ParallelPrior, EqualsTheCpusPrior) {
  const SerialExecutor executor;
  for (const Named& named : stories()) {
    const std::vector<std::uint8_t> cpu = named.story.computed_by_cpu(),
                                    own = named.story.voxels_of(named.story.parallel(executor));
    ASSERT_GT(*std::max_element(cpu.begin(), cpu.end()), 128) << named.name;
    const Difference d = difference(cpu, own);
    EXPECT_LT(d.mean, 0.1) << named.name;
    // Larger differences: at long geodesic paths in noise, and between two new marks at equal distance.
    EXPECT_LT(d.far, 0.003 * static_cast<double>(cpu.size())) << named.name << ", up to " << d.most;
  }
}

TEST(ParallelPrior, EverySettingHasAnEffect) {
  const SerialExecutor executor;
  const Story story(ellipsoid(32, 1, {10, 7, 8}, 25).image, {inside({0, 0, 0}, 6)}, {outside({12, 0, 0}, 2)});
  const std::vector<std::uint8_t> usual = story.voxels_of(story.parallel(executor));
  for (bool EvidenceSettings::*const use : {&EvidenceSettings::use_appearance, &EvidenceSettings::use_geodesic,
                                            &EvidenceSettings::use_random_walk, &EvidenceSettings::memory}) {
    EvidenceSettings settings;
    settings.*use = false;
    const std::vector<std::uint8_t> own = story.voxels_of(story.parallel(executor, settings));
    EXPECT_GT(difference(usual, own).most, 0);
    EXPECT_LT(difference(story.computed_by_cpu(settings), own).mean, 0.1);
  }
  EvidenceSettings settings;
  settings.memory = settings.expected_dice_threshold = false;
  EXPECT_LT(difference(story.computed_by_cpu(settings), story.voxels_of(story.parallel(executor, settings))).mean, 0.1);
}

TEST(ParallelPrior, OpensTheSameSidesOfTheBox) {
  const Scene bar = ellipsoid(40, 1, {400, 8, 8}, 5);  // it extends beyond the box
  const SerialExecutor executor;
  const Story story(VoxelBox{{8, 4, 4}, {24, 32, 32}}, bar.image, inside({0, 0, 0}, 6));
  const std::vector<std::uint8_t> cpu = story.open_by_cpu();
  std::vector<std::uint8_t> own(cpu.size(), 7);
  story.parallel(executor).mark_open(story.known().data(), own.data());
  EXPECT_EQ(own, cpu);
  EXPECT_GT(std::count(cpu.begin(), cpu.end(), 1), 20);
}

TEST(ParallelPrior, IsReproducibleForAnyNumberOfUpdates) {
  const Counting executor;
  const Scene scene = ellipsoid(36, 1, {12, 10, 9}, 25);
  const Story one(scene.image, {inside({0, 0, 0}, 8)}, {outside({15, 0, 0}, 3)}),
      other(scene.image, {inside({0, 0, 0}, 8)}, {inside({9, 3, 1}, 2), boundary({0, 10, 0}, 2.5, {0, 1, 0})});
  ParallelPrior<Counting> prior = one.parallel(executor);
  one.learn(prior);  // the random walker starts from its last solution
  const std::vector<std::uint8_t> first = one.voxels_of(prior);
  EXPECT_LT(difference(first, one.voxels_of(one.parallel(executor))).mean, 0.1);
  const std::size_t bytes = prior.bytes();
  executor.launches = executor.waits = executor.uploads = 0;
  one.learn(prior);
  EXPECT_EQ(prior.bytes(), bytes);  // no further allocation
  RecordProperty("launches", executor.launches);
  RecordProperty("waits", executor.waits);
  EXPECT_LT(executor.launches, 100);
  EXPECT_LT(executor.waits, 20);
  EXPECT_LT(difference(first, one.voxels_of(prior)).most, 6);
  other.learn(prior);
  EXPECT_GT(difference(first, one.voxels_of(prior)).most, 20);
  EXPECT_LT(difference(other.computed_by_cpu(), other.voxels_of(prior)).mean, 0.1);
}

}  // namespace
}  // namespace simplexseg
