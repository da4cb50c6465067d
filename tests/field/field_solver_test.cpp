// SPDX-License-Identifier: Apache-2.0
// Evidence fields on the executor of the CPU and on that of a CUDA device, which is compared with the CPU.
#include "field/parallel/field_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "ellipsoid_scene.h"
#include "field/evidence_field.h"
#include "gpu/backend.h"
#include "image/metrics.h"
#include "references.h"

namespace simplexseg {
namespace {

Mark boundary(const Eigen::Vector3d& at, const Eigen::Vector3d& outward) {
  return {MarkKind::Boundary, at, 1.8, outward};
}

class ParallelField : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (GetParam() == "cuda" && !cuda_unavailable_reason().empty())
      GTEST_SKIP() << "skipped: no CUDA device (" << cuda_unavailable_reason() << ")";
  }
  static EvidenceField field_of(const Scene& scene, const EvidenceSettings& settings = {}) {
    return EvidenceField(scene.image, run_serially(), settings,
                         GetParam() == "cuda" ? MakeFieldSolver(make_cuda_field_solver) : make_cpu_field_solver);
  }

  /// Updates a field mark by mark, from the seed on, and checks it after each mark. The last object has at least this
  /// Dice with the true one.
  static EvidenceField follow(const Scene& scene, const std::vector<Mark>& marks, double least_dice,
                              std::span<const Mark> others = {}) {
    EvidenceField cpu(scene.image), field = field_of(scene);
    for (std::size_t count = 1; count <= marks.size(); ++count) {
      const std::span<const Mark> now(marks.data(), count);
      field.update(now, others);
      expect_obeys(field, scene, now, others);
      if (GetParam() != "cuda") continue;
      cpu.update(now, others);
      expect_equal(field, cpu, count);
    }
    EXPECT_GE(dice(scene.truth, field.object()), least_dice);
    return field;
  }
  static void expect_obeys(const EvidenceField& field, const Scene& scene, std::span<const Mark> marks,
                           std::span<const Mark> others) {
    std::vector<Constraint> constraints(field.box().voxel_count(), Constraint::None);
    each_index({field.box().size}, [&](int i, int j, int k, int v) {
      const std::array<int, 3>& first = field.box().first;
      const float value = scene.image.voxels<float>()[scene.image.offset(first[0] + i, first[1] + j, first[2] + k)];
      if (!std::isfinite(value)) constraints[v] = Constraint::NotFinite;
    });
    for (const Mark& other : others)
      paint_ball(constraints, scene.image.geometry(), field.box(), other.position_mm, other.radius_mm,
                 Constraint::OtherObject);
    paint_marks(constraints, scene.image.geometry(), field.box(), marks);
    for (std::size_t v = 0; v < constraints.size(); ++v) {
      const float p = field.probability()[v];
      ASSERT_TRUE(p >= 0 && p <= 1) << v << ": " << p;
      if (constraints[v] != Constraint::None && constraints[v] != Constraint::NotFinite) {
        ASSERT_EQ(p, constraints[v] == Constraint::Inside ? 1 : 0) << v << " after " << marks.size() << " marks";
      }
    }
    const double expected_dice = field.report().expected_dice;
    EXPECT_TRUE(expected_dice > 0.5 && expected_dice <= 1) << expected_dice;
  }
  static void expect_equal(const EvidenceField& field, const EvidenceField& cpu, std::size_t count) {
    ASSERT_EQ(field.box(), cpu.box()) << count;
    EXPECT_NEAR(field.report().beta, cpu.report().beta, 1e-3 * cpu.report().beta) << count;
    EXPECT_EQ(field.report().leaks, cpu.report().leaks) << count;
    EXPECT_EQ(field.report().growths, cpu.report().growths) << count;
    EXPECT_NEAR(field.report().expected_dice, cpu.report().expected_dice, 0.01) << count;
    EXPECT_GE(dice(field.object(), cpu.object()), 0.985) << count;
    double sum = 0;
    for (std::size_t v = 0; v < cpu.probability().size(); ++v)
      sum += std::fabs(field.probability()[v] - cpu.probability()[v]);
    EXPECT_LE(sum / static_cast<double>(cpu.probability().size()), 0.01) << count;
  }
};

/// Marks of all kinds in noisy_ellipsoid(), at its surface and beside it.
const std::vector<Mark> kManyMarks{inside({0, 0, 0}, 6),     inside({15, 0, 0}, 1.8),
                                   outside({0, 15, 0}, 2.5), boundary({0, 0, 10}, {0, 0, 1}),
                                   outside({21, 0, 0}, 3),   inside({0, -11, 1}, 1.2)};
Scene noisy_ellipsoid() { return ellipsoid(56, 1, {18, 13, 10}, 30); }

TEST_P(ParallelField, FollowsEachOfManyMarks) { follow(noisy_ellipsoid(), kManyMarks, 0.95); }
TEST_P(ParallelField, SolvesThickSlices) {
  follow(ellipsoid(60, 4, {20, 16, 22}, 25), {inside({2, 1, 0}, 8), outside({0, 20, 4}, 2), inside({-17, 0, 0}, 2)},
         0.94);
}
TEST_P(ParallelField, GrowsWhereTheVolumeCutsTheObject) {
  const Scene scene = ellipsoid(64, 1, {26, 40, 20}, 15);
  const EvidenceField field = follow(
      scene, {inside({-10, -20, 0}, 5), outside({28, 0, 0}, 2), inside({0, 0, 0}, 5), inside({10, 20, 0}, 5)}, 0.9);
  EXPECT_EQ(field.box(), (VoxelBox{{0, 0, 0}, {64, 64, 64}}));
  EvidenceField from_seed = field_of(scene);
  from_seed.update(std::vector{inside({-10, -20, 0}, 5)});
  EXPECT_GT(from_seed.report().growths, 0);
}
TEST_P(ParallelField, SolvesASingleSlice) {
  const Scene scene = ellipsoid(48, 40, {15, 12, 30}, 20);
  ASSERT_EQ(scene.image.geometry().size[2], 1);
  follow(scene, {inside({0, 0, 0}, 5), outside({18, 0, 0}, 2)}, 0.93);
}
TEST_P(ParallelField, HandlesOtherObjectsAndVoxelsThatAreNotFinite) {
  const int width = 48;
  Scene scene = ellipsoid(width, 1, {16, 12, 12}, 20);
  for (int j = 0; j < width; ++j)
    for (int i = 30; i < 34; ++i) scene.image.voxels<float>()[scene.image.offset(i, j, 20)] = NAN;
  const std::vector<Mark> others{inside({-12, 0, 0}, 4)};
  follow(scene, {inside({4, 0, 0}, 5), inside({14, 0, 0}, 1.8)}, 0.85, others);
  EvidenceField with = field_of(scene), without = field_of(scene);
  const std::vector<Mark> seed{inside({4, 0, 0}, 5)};
  with.update(seed, others);
  without.update(seed);
  const Mask a = with.object(), b = without.object();
  const Eigen::Affine3d world = scene.image.geometry().world_from_index();
  int shared = 0, beside = 0;
  for (std::size_t v = 0; v < a.voxels.size(); ++v) {
    const auto at = static_cast<int>(v);
    const Eigen::Vector3d index(at % width, at / width % width, at / (width * width));
    const bool in_other = (world * index - others[0].position_mm).norm() < others[0].radius_mm;
    shared += a.voxels[v] && in_other;
    beside += b.voxels[v] && in_other;
  }
  EXPECT_EQ(shared, 0);
  EXPECT_GT(beside, 0);
}

TEST_P(ParallelField, IsReproducible) {
  const Scene scene = ellipsoid(56, 1, {18, 13, 10}, 40);
  const std::vector<Mark> marks{inside({0, 0, 0}, 6), inside({15, 0, 0}, 1.8), outside({0, 15, 0}, 2.5)};
  std::vector<std::vector<float>> fields;
  for (int run = 0; run < (GetParam() == "cuda" ? 5 : 2); ++run) {
    EvidenceField field = field_of(scene);
    for (std::size_t count = 1; count <= marks.size(); ++count) field.update({marks.data(), count});
    fields.emplace_back(field.probability().begin(), field.probability().end());
    EXPECT_EQ(fields.back(), fields.front());
  }
}

TEST_P(ParallelField, ARemovedMarkHasNoEffect) {
  const Scene scene = ellipsoid(30, 1, {10, 8, 7}, 25);
  const std::vector<Mark> seed{inside({0, 0, 0}, 4)}, more{seed[0], outside({7, 0, 0}, 2)};
  EvidenceField field = field_of(scene);
  field.update(seed);
  const Mask previous = field.object();
  field.update(more);
  EXPECT_LT(dice(field.object(), previous), 0.99);
  field.update(seed);
  EXPECT_GT(dice(field.object(), previous), 0.99);
}

TEST_P(ParallelField, ReportsAnIncreasingFraction) {
  const Scene scene = ellipsoid(30, 1, {10, 8, 7}, 25);
  EvidenceField field = field_of(scene);
  std::vector<Mark> marks{inside({0, 0, 0}, 4)};
  for (int update = 0; update < 2; ++update) {
    std::vector<float> fractions{0};
    field.update(marks, {}, [&](float fraction) {
      EXPECT_GT(fraction, fractions.back());
      fractions.push_back(fraction);
    });
    EXPECT_GT(fractions.size(), 5u);  // constraints, prior, features, walker, surface
    EXPECT_GT(fractions.back(), 0.9f);
    EXPECT_LT(fractions.back(), 1.0f);
    marks.push_back(outside({7, 0, 0}, 2));
  }
}

/// With axes at right angles in parallel, else by field_values() on the host.
TEST_P(ParallelField, ValuesAreThoseOfTheObjectAndTheProbability) {
  for (const bool sheared : {false, true}) {
    Scene scene = ellipsoid(32, 1, {11, 8, 7}, 10);
    if (sheared) {
      VolumeGeometry geometry = scene.image.geometry();
      geometry.direction << 1, 0.2, 0.1, 0, 1, 0.1, 0.1, 0, 1;
      Volume volume(geometry, VoxelType::Float32);
      std::ranges::copy(scene.image.voxels<float>(), volume.voxels<float>().begin());
      scene.image = std::move(volume);
    }
    EvidenceField field = field_of(scene);
    field.update(std::vector{inside(scene.image.geometry().world_from_index() * Eigen::Vector3d(16, 16, 16), 5)});
    const FieldValue value{60000, 24000, 1500, 3000, 2};
    const std::vector<std::uint16_t> values = field.values(value),
                                     expected =
                                         field_values(field.object_in_box().voxels, field.probability(), field.box(),
                                                      scene.image.geometry(), value, run_serially());
    ASSERT_EQ(values.size(), expected.size());
    for (std::size_t v = 0; v < values.size(); ++v) ASSERT_NEAR(values[v], expected[v], 1) << v;
    EXPECT_GT(std::ranges::count_if(values, [](std::uint16_t x) { return x > 30000; }), 1000);
  }
}

struct LeftOut {
  const char* name;
  void (*change)(EvidenceSettings&);
};

TEST_P(ParallelField, EveryPartCanBeSwitchedOff) {
  const Scene scene = ellipsoid(28, 1, {9, 7, 6}, 40);
  const std::vector<Mark> marks{
      inside({0, 0, 0}, 4), outside({8, 0, 0}, 1), {MarkKind::Boundary, {0, 6, 0}, 1, {0, 1, 0}}};
  const auto field_with = [&](void (*change)(EvidenceSettings&)) {
    EvidenceSettings settings;
    change(settings);
    EvidenceField field = field_of(scene, settings);
    field.update({marks.data(), 1});
    field.update(marks);
    return std::vector<float>(field.probability().begin(), field.probability().end());
  };
  const std::vector<float> whole = field_with([](EvidenceSettings&) {});
  for (const LeftOut& part :
       {LeftOut{"appearance", [](EvidenceSettings& s) { s.use_appearance = false; }},
        LeftOut{"geodesic", [](EvidenceSettings& s) { s.use_geodesic = false; }},
        LeftOut{"random walk", [](EvidenceSettings& s) { s.use_random_walk = false; }},
        LeftOut{"memory", [](EvidenceSettings& s) { s.memory = false; }},
        LeftOut{"far memory", [](EvidenceSettings& s) { s.far_memory = 0; }},
        LeftOut{"far change", [](EvidenceSettings& s) { s.far_change = 0; }},
        LeftOut{"expected-Dice threshold", [](EvidenceSettings& s) { s.expected_dice_threshold = false; }},
        LeftOut{"surface", [](EvidenceSettings& s) { s.band_half_width = 0; }},
        LeftOut{"surface offset", [](EvidenceSettings& s) { s.band_offset = 0; }},
        LeftOut{"surface memory", [](EvidenceSettings& s) { s.temporal_weight = 0; }},
        LeftOut{"surface pull", [](EvidenceSettings& s) { s.shift_weight = 0; }},
        LeftOut{"sharpness", [](EvidenceSettings& s) { s.sharpness = 0; }},
        LeftOut{"prior", [](EvidenceSettings& s) { s.prior_weight = 0; }},
        LeftOut{"smoothing", [](EvidenceSettings& s) { s.field_smoothing = 0; }},
        LeftOut{"blocks", [](EvidenceSettings& s) { s.blocks_per_scale = 2; }},
        LeftOut{"smoother image", [](EvidenceSettings& s) { s.image_smoothing = 2; }}})
    EXPECT_TRUE(field_with(part.change) != whole) << part.name;
}

TEST_P(ParallelField, AddsAShapePrior) {
  const Scene scene = ellipsoid(32, 1, {11, 8, 7}, 40);
  const auto prior = std::make_shared<ShapePrior>();  // an object that ends at x = 4 mm
  prior->grid = scene.image.geometry();
  prior->bounds_mm = {Eigen::Vector3d(-11, -8, -7), Eigen::Vector3d(4, 8, 7)};
  prior->outside = -8;
  each_index({scene.image.geometry().size}, [&](int i, int, int, int v) {
    prior->log_odds.push_back(scene.truth.voxels[v] != 0 && i < 20 ? 8.0f : -8.0f);
  });
  const std::vector<Mark> marks{inside({-3, 0, 0}, 4), outside({0, 9, 0}, 2)};
  EvidenceField cpu(scene.image), field = field_of(scene), without = field_of(scene);
  for (EvidenceField* both : {&cpu, &field}) both->set_shape_prior([&](std::span<const Mark>) { return prior; });
  for (std::size_t count = 1; count <= marks.size(); ++count) {
    const std::span<const Mark> now(marks.data(), count);
    for (EvidenceField* all : {&cpu, &field, &without}) all->update(now);
    if (GetParam() == "cuda") expect_equal(field, cpu, count);
    const auto beyond = [&](const EvidenceField& one) {  // voxels at x > 4 mm
      const Mask object = one.object();
      std::size_t found = 0;
      each_index({scene.image.geometry().size},
                 [&](int i, int, int, int v) { found += i > 20 && object.voxels[v] != 0; });
      return found;
    };
    EXPECT_LT(beyond(field), beyond(without) / 4) << count;
  }
}

INSTANTIATE_TEST_SUITE_P(Executors, ParallelField, ::testing::Values("cpu", "cuda"),
                         [](const auto& info) { return info.param; });

class FieldOnDevice : public ParallelField {};

TEST_P(FieldOnDevice, TheRadiusOfAMarkEqualsTheCpus) {
  const Scene scene = ellipsoid(32, 1, {11, 8, 7});
  EvidenceField cpu(scene.image), field = field_of(scene);
  const std::vector<Mark> seed{inside({0, 0, 0}, 5)};
  cpu.update(seed);
  field.update(seed);
  for (const Eigen::Vector3d& at : {Eigen::Vector3d(0, 0, 3), Eigen::Vector3d(13, 0, 0), Eigen::Vector3d(0, 7, 0)})
    EXPECT_NEAR(field.brush_mm(MarkKind::Outside, at), cpu.brush_mm(MarkKind::Outside, at), 0.5) << at.transpose();
  EXPECT_GT(field.bytes(), field.box().voxel_count() * 20);
}

TEST_P(FieldOnDevice, RecordsTheFeaturesOfTheCpu) {
  const Scene scene = noisy_ellipsoid();
  EvidenceField cpu(scene.image), field = field_of(scene);
  for (EvidenceField* both : {&cpu, &field}) {
    both->record_features(true);
    both->update({kManyMarks.data(), 1});
    both->update({kManyMarks.data(), 3});
  }
  const PriorFeatures &a = field.features(), &b = cpu.features();
  EXPECT_EQ(a.size, b.size);
  EXPECT_EQ(a.constraints, b.constraints);
  ASSERT_EQ(a.marks.size(), b.marks.size());
  ASSERT_EQ(a.update.size(), b.update.size());
  const auto far = [](const std::vector<float>& x, const std::vector<float>& y) {
    std::size_t count = 0;
    for (std::size_t v = 0; v < x.size(); ++v) count += !(std::fabs(x[v] - y[v]) < 0.2f);
    return count;
  };
  for (std::size_t f = 0; f < a.marks.size(); ++f)
    EXPECT_LT(far(a.marks[f], b.marks[f]), b.constraints.size() / 50) << "of all marks, " << f;
  for (std::size_t f = 0; f < a.update.size(); ++f)
    EXPECT_LT(far(a.update[f], b.update[f]), b.constraints.size() / 50) << "of new marks, " << f;
}

INSTANTIATE_TEST_SUITE_P(Executors, FieldOnDevice, ::testing::Values("cuda"),
                         [](const auto& info) { return info.param; });

/// After each of several marks: the field, its object and its report, and the features of the prior.
TEST(FieldOfAnyThreads, HasTheSameBits) {
  const Scene scene = ellipsoid(46, 1, {14, 10, 9}, 30);
  const std::vector<Mark> marks{inside({0, 0, 0}, 6), outside({0, 12, 0}, 2.5), boundary({0, 0, 9}, {0, 0, 1}),
                                inside({12, 0, 0}, 1.8)};
  EvidenceField in_turn(scene.image);
  in_turn.record_features(true);
  std::vector<EvidenceField> others;
  const std::vector<JobOrder> orders = job_orders();
  for (const JobOrder& order : orders) others.emplace_back(scene.image, order.run).record_features(true);
  for (std::size_t count = 1; count <= marks.size(); ++count) {
    in_turn.update({marks.data(), count});
    for (std::size_t o = 0; o < orders.size(); ++o) {
      EvidenceField& field = others[o];
      field.update({marks.data(), count});
      const std::string where = orders[o].name + " after mark " + std::to_string(count);
      ASSERT_EQ(field.box(), in_turn.box()) << where;
      EXPECT_TRUE(std::ranges::equal(field.probability(), in_turn.probability())) << where;
      EXPECT_EQ(field.object_in_box().voxels, in_turn.object_in_box().voxels) << where;
      EXPECT_EQ(field.report().iterations, in_turn.report().iterations) << where;
      EXPECT_EQ(field.report().error, in_turn.report().error) << where;
      EXPECT_EQ(field.report().beta, in_turn.report().beta) << where;
      EXPECT_EQ(field.report().expected_dice, in_turn.report().expected_dice) << where;
      EXPECT_EQ(field.features().marks, in_turn.features().marks) << where;
      EXPECT_EQ(field.features().update, in_turn.features().update) << where;
      EXPECT_EQ(field.features().near_inside, in_turn.features().near_inside) << where;
    }
  }
}

/// The scene with its contrast inverted and other noise, and an image without the object.
FieldImages further_images(const Scene& scene) {
  FieldImages images;
  const Scene again = ellipsoid(40, 1, {13, 11, 9}, 60), noise = ellipsoid(40, 1, {0.1, 0.1, 0.1}, 25);
  Volume inverted(scene.image.geometry(), VoxelType::Float32);
  for (std::size_t v = 0; v < inverted.voxels<float>().size(); ++v)
    inverted.voxels<float>()[v] = 300 - again.image.voxels<float>()[v];
  images.further = {std::move(inverted), noise.image};
  return images;
}

TEST_P(ParallelField, OfSeveralImagesIsEqualOnAllExecutors) {
  const Scene scene = ellipsoid(40, 1, {13, 11, 9}, 50);
  std::vector<Mark> marks{inside({0, 0, 0}, 5)};
  EvidenceField cpu(scene.image), field = field_of(scene), alone(scene.image);
  cpu.set_images(further_images(scene));
  field.set_images(further_images(scene));
  for (const Mark& next : {outside({17, 0, 0}, 2), inside({9, 0, 0}, 2)}) {
    cpu.update(marks), field.update(marks), alone.update(marks);
    expect_equal(field, cpu, marks.size());
    EXPECT_FALSE(std::ranges::equal(cpu.probability(), alone.probability()));
    marks.push_back(next);
  }
}

TEST(FieldOfImages, UsesTheMainImageInsteadOfTheVolume) {
  const Scene seen = ellipsoid(36, 1, {12, 10, 9}, 25), hidden = ellipsoid(36, 1, {0.1, 0.1, 0.1}, 25);
  const std::vector<Mark> marks{inside({0, 0, 0}, 6)};
  EvidenceField direct(seen.image), through(hidden.image);
  FieldImages images;
  images.main = seen.image;
  through.set_images(std::move(images));
  direct.update(marks), through.update(marks);
  EXPECT_GT(dice(seen.truth, direct.object()), 0.9);
  EXPECT_TRUE(std::ranges::equal(direct.probability(), through.probability()));
  FieldImages other_grid;
  other_grid.further = {ellipsoid(20, 1, {3, 3, 3}).image};
  EXPECT_THROW(through.set_images(std::move(other_grid)), Error);
}

TEST(FieldFeatures, AreRecordedOnRequest) {
  const Scene scene = ellipsoid(36, 1, {12, 10, 9}, 25);
  EvidenceField field(scene.image);
  std::vector<Mark> marks{inside({0, 0, 0}, 8)};
  field.update(marks);
  EXPECT_TRUE(field.features().marks.empty());
  field.record_features(true);
  marks.push_back(outside({15, 0, 0}, 3));
  field.update(marks);
  const PriorFeatures& features = field.features();
  const auto blocks = static_cast<std::size_t>(features.size[0] * features.size[1] * features.size[2]);
  EXPECT_EQ(features.size, field.box().size);  // blocks of one voxel
  EXPECT_EQ(features.constraints.size(), blocks);
  EXPECT_EQ(features.near_inside, std::vector<std::uint8_t>(blocks));  // the new mark is an outside one
  EXPECT_EQ(features.marks.size(), static_cast<std::size_t>(MarkView::kFeatures));
  EXPECT_EQ(features.update.size(), static_cast<std::size_t>(UpdateView::kFeatures));
  for (const auto* lists : {&features.marks, &features.update})
    for (const std::vector<float>& list : *lists) {
      ASSERT_EQ(list.size(), blocks);
      for (const float x : list) ASSERT_TRUE(std::isfinite(x));
    }
  // Without new marks there is nothing for the second network.
  field.update(std::vector{inside({1, 0, 0}, 8)});
  EXPECT_EQ(field.features().marks.size(), static_cast<std::size_t>(MarkView::kFeatures));
  EXPECT_TRUE(field.features().update.empty());
  EXPECT_TRUE(field.features().near_inside.empty());
  field.record_features(false);
  const std::vector<std::vector<float>> last = field.features().marks;
  field.update(std::vector{inside({-2, 0, 0}, 7)});
  EXPECT_EQ(field.features().marks, last);
}

}  // namespace
}  // namespace simplexseg
