// SPDX-License-Identifier: Apache-2.0
#include "image/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"
#include "support/empty_mask.h"

namespace simplexseg {
namespace {

constexpr double inf = std::numeric_limits<double>::infinity();

std::uint8_t& at(Mask& mask, int i, int j, int k) {
  return mask.voxels[(std::size_t(k) * mask.geometry.size[1] + j) * mask.geometry.size[0] + i];
}

/// Mask of a sphere as in the tests of MONAI: 99^3 voxels; voxel i is set if |i * spacing - centre| <= radius.
Mask monai_sphere(double radius, const Eigen::Vector3d& centre, const Eigen::Vector3d& spacing = {1, 1, 1}) {
  Mask mask = empty_mask({99, 99, 99}, spacing);
  for (int k = 0; k < 99; ++k)
    for (int j = 0; j < 99; ++j)
      for (int i = 0; i < 99; ++i)
        at(mask, i, j, k) = (Eigen::Vector3d(i, j, k).cwiseProduct(spacing) - centre).norm() <= radius;
  return mask;
}

/// Reference implementation: distance from each boundary voxel of one mask to the nearest boundary voxel of the other.
struct BruteForce {
  static std::vector<Eigen::Vector3d> boundary(const Mask& mask) {
    const auto [ni, nj, nk] = mask.geometry.size;
    const auto set = [&, ni = ni, nj = nj, nk = nk](int i, int j, int k) {
      return i >= 0 && j >= 0 && k >= 0 && i < ni && j < nj && k < nk &&
             mask.voxels[(std::size_t(k) * nj + j) * ni + i] != 0;
    };
    std::vector<Eigen::Vector3d> points;
    for (int k = 0; k < nk; ++k)
      for (int j = 0; j < nj; ++j)
        for (int i = 0; i < ni; ++i)
          if (set(i, j, k) && !(set(i - 1, j, k) && set(i + 1, j, k) && set(i, j - 1, k) && set(i, j + 1, k) &&
                                set(i, j, k - 1) && set(i, j, k + 1)))
            points.push_back(mask.geometry.world_from_index() * Eigen::Vector3d(i, j, k));
    return points;
  }
  static std::vector<double> distances(const Mask& from, const Mask& to) {
    const auto targets = boundary(to);
    std::vector<double> result;
    for (const auto& p : boundary(from)) {
      double nearest = inf;
      for (const auto& q : targets) nearest = std::min(nearest, (p - q).norm());
      result.push_back(nearest);
    }
    std::sort(result.begin(), result.end());
    return result;
  }
  static double percentile95(const std::vector<double>& sorted) {
    const double rank = 0.95 * double(sorted.size() - 1);
    const std::size_t low = std::size_t(rank);
    return low + 1 < sorted.size() ? sorted[low] + (rank - double(low)) * (sorted[low + 1] - sorted[low]) : sorted[low];
  }
  static double mean(const std::vector<double>& values) {
    double sum = 0;
    for (double v : values) sum += v;
    return sum / double(values.size());
  }
};

void expect_agrees_with_definition(const Mask& reference, const Mask& test) {
  const auto forth = BruteForce::distances(reference, test), back = BruteForce::distances(test, reference);
  const Agreement a = compare(reference, test);
  EXPECT_NEAR(a.hd_directed_mm, forth.back(), 1e-9);
  EXPECT_NEAR(a.hd_mm, std::max(forth.back(), back.back()), 1e-9);
  EXPECT_NEAR(a.hd95_directed_mm, BruteForce::percentile95(forth), 1e-9);
  EXPECT_NEAR(a.hd95_mm, std::max(BruteForce::percentile95(forth), BruteForce::percentile95(back)), 1e-9);
  EXPECT_NEAR(a.asd_directed_mm, BruteForce::mean(forth), 1e-9);
  EXPECT_NEAR(a.assd_mm, 0.5 * (BruteForce::mean(forth) + BruteForce::mean(back)), 1e-9);
}

TEST(Metrics, MonaiIdenticalMasks) {
  const Mask mask = monai_sphere(20, {20, 20, 20});
  const Agreement a = compare(mask, mask);
  EXPECT_EQ(a.dice, 1);
  for (double d : {a.hd_mm, a.hd95_mm, a.assd_mm, a.hd_directed_mm, a.hd95_directed_mm, a.asd_directed_mm})
    EXPECT_EQ(d, 0);
}

TEST(Metrics, MonaiShiftedAlongTheDiagonal) {
  const Agreement a = compare(monai_sphere(20, {20, 20, 20}), monai_sphere(20, {19, 19, 19}));
  EXPECT_NEAR(a.hd_directed_mm, 1.7320508, 1e-7);
  EXPECT_NEAR(a.hd_mm, 1.7320508, 1e-7);
  EXPECT_NEAR(a.dice, 0.934984, 1e-6);
}

TEST(Metrics, MonaiLargeSpheresShiftedByOne) {
  const Agreement a = compare(monai_sphere(33, {19, 33, 22}), monai_sphere(33, {20, 33, 22}));
  EXPECT_NEAR(a.hd_directed_mm, 1, 1e-9);
  EXPECT_NEAR(a.hd_mm, 1, 1e-9);
  EXPECT_NEAR(a.asd_directed_mm, 0.348327881, 1e-8);
  EXPECT_NEAR(a.assd_mm, 0.350212007, 1e-8);
  EXPECT_NEAR(a.dice, 0.983961, 1e-6);
}

TEST(Metrics, MonaiOneSphereInsideAnother) {
  const Agreement a = compare(monai_sphere(20, {20, 33, 22}), monai_sphere(40, {20, 33, 22}));
  EXPECT_NEAR(a.hd_directed_mm, 20.099751242, 1e-8);
  EXPECT_NEAR(a.hd_mm, 20.223748417, 1e-8);
  EXPECT_NEAR(a.hd95_directed_mm, 19.924858845, 1e-8);
  EXPECT_NEAR(a.hd95_mm, 20.099751242, 1e-8);
  EXPECT_NEAR(a.asd_directed_mm, 12.040033513, 1e-8);
  EXPECT_NEAR(a.assd_mm, 13.975673696, 1e-8);
  EXPECT_NEAR(a.dice, 0.295721, 1e-6);
}

TEST(Metrics, MonaiAnisotropicSpacing) {
  // The published values were computed with a float spacing, hence the larger tolerances.
  const Eigen::Vector3d s(.85, 1.2, .9);
  const Agreement shifted = compare(monai_sphere(20, {20, 20, 20}, s), monai_sphere(20, {19, 19, 19}, s));
  EXPECT_NEAR(shifted.hd_directed_mm, 2.080865145, 1e-6);
  EXPECT_NEAR(shifted.hd_mm, 2.2671568, 1e-6);
  EXPECT_NEAR(shifted.dice, 0.934801, 1e-6);
  const Agreement nested = compare(monai_sphere(15, {20, 33, 22}, s), monai_sphere(30, {20, 33, 22}, s));
  EXPECT_NEAR(nested.hd_directed_mm, 15.439640999, 1e-6);
  EXPECT_NEAR(nested.hd_mm, 15.62594, 1e-5);
  EXPECT_NEAR(nested.dice, 0.245991, 1e-6);
}

TEST(Metrics, EmptyMasks) {
  const Mask none = empty_mask({99, 99, 99}), some = monai_sphere(5, {20, 20, 20});
  for (const Agreement& a : {compare(none, some), compare(some, none)}) {
    EXPECT_EQ(a.dice, 0);
    for (double d : {a.hd_mm, a.hd95_mm, a.assd_mm, a.hd_directed_mm, a.hd95_directed_mm, a.asd_directed_mm})
      EXPECT_EQ(d, inf);
  }
  const Agreement both = compare(none, none);
  EXPECT_EQ(both.dice, 1);
  EXPECT_EQ(both.hd_mm, 0);
  EXPECT_EQ(both.assd_mm, 0);
  EXPECT_EQ(dice(none, some), 0);
  EXPECT_EQ(dice(none, none), 1);
}

// MedPy averages the pooled distances of both directions. This equals the mean of the two directed means, each weighted
// by its number of boundary voxels.
TEST(Metrics, MedPyCornerAgainstDiagonal) {
  Mask corner = empty_mask({4, 4, 4}), diagonal = empty_mask({4, 4, 4});
  at(corner, 0, 0, 0) = 1;
  for (int i = 0; i < 4; ++i) at(diagonal, i, i, i) = 1;
  const Agreement forth = compare(corner, diagonal), back = compare(diagonal, corner);
  EXPECT_NEAR(forth.hd_mm, 5.196152423, 1e-8);
  EXPECT_EQ(forth.hd_directed_mm, 0);
  EXPECT_NEAR((1 * forth.asd_directed_mm + 4 * back.asd_directed_mm) / 5, 2.078460969, 1e-8);
}

TEST(Metrics, MedPyHollowCubeAgainstItsCentre) {
  Mask cube = empty_mask({5, 5, 5}), centre = empty_mask({5, 5, 5});
  for (int k = 1; k < 4; ++k)
    for (int j = 1; j < 4; ++j)
      for (int i = 1; i < 4; ++i) at(cube, i, j, k) = 1;
  at(cube, 2, 2, 2) = 0;
  at(centre, 2, 2, 2) = 1;
  const Agreement forth = compare(cube, centre), back = compare(centre, cube);
  EXPECT_NEAR(forth.hd_mm, 1.73205080757, 1e-9);
  EXPECT_NEAR((26 * forth.asd_directed_mm + 1 * back.asd_directed_mm) / 27, 1.40099885959, 1e-9);
  EXPECT_EQ(forth.dice, 0);
}

TEST(Metrics, RandomMasksAgreeWithTheDefinitionOnEveryKindOfGrid) {
  std::mt19937 random(7);
  const Eigen::Matrix3d rotation = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity(), slight = shear;
  shear(0, 2) = 0.7;
  shear(0, 1) = -0.3;
  slight(1, 2) = 1e-3;
  Eigen::Matrix3d left_handed = rotation;
  left_handed.col(1) *= -1;
  const std::vector<Eigen::Matrix3d> directions{
      Eigen::Matrix3d::Identity(), rotation, left_handed, rotation * shear, slight, 2.0 * rotation};
  for (const Eigen::Matrix3d& direction : directions) {
    for (double density : {0.002, 0.05, 0.6}) {
      Mask a = empty_mask({17, 12, 23}, {0.7, 1.9, 1.1});
      a.geometry.direction = direction;
      Mask b = a;
      for (auto& v : a.voxels) v = random() < density * 4294967295.0;
      for (auto& v : b.voxels) v = random() < density * 4294967295.0;
      at(a, 0, 11, 3) = 1;
      at(b, 9, 2, 22) = 1;
      expect_agrees_with_definition(a, b);
    }
  }
}

TEST(Metrics, ShapesOnASlightlyShearedGridAgreeWithTheSeparablePath) {
  // A shear of 2e-5 just exceeds the tolerance for orthogonal axes. The k-d tree for sheared grids must agree there
  // with the separable distance transform.
  const Mask straight_a = monai_sphere(20, {40, 33, 40}), straight_b = monai_sphere(26, {42, 33, 40});
  Mask a = straight_a, b = straight_b;
  a.geometry.direction(0, 1) = b.geometry.direction(0, 1) = 2e-5;
  const Agreement straight = compare(straight_a, straight_b), sheared = compare(a, b);
  EXPECT_NEAR(sheared.hd_mm, straight.hd_mm, 1e-3);
  EXPECT_NEAR(sheared.hd95_mm, straight.hd95_mm, 1e-3);
  EXPECT_NEAR(sheared.assd_mm, straight.assd_mm, 1e-3);
  EXPECT_EQ(sheared.dice, straight.dice);
}

TEST(Metrics, VolumesAreInCubicMillimetres) {
  Mask a = empty_mask({5, 5, 5}, {0.5, 2, 3}), b = a;
  a.geometry.direction(0, 1) = b.geometry.direction(0, 1) = 1;  // a shear preserves the volume
  at(a, 0, 0, 0) = at(a, 4, 4, 4) = at(b, 4, 4, 4) = 1;
  const Agreement result = compare(a, b);
  EXPECT_DOUBLE_EQ(result.reference_mm3, 6);
  EXPECT_DOUBLE_EQ(result.test_mm3, 3);
  EXPECT_DOUBLE_EQ(result.dice, 2.0 / 3);
  EXPECT_DOUBLE_EQ(dice(a, b), 2.0 / 3);
}

TEST(Metrics, TheImageBorderCountsAsOutside) {
  Mask full = empty_mask({5, 5, 5}), centre = empty_mask({5, 5, 5});
  std::fill(full.voxels.begin(), full.voxels.end(), 1);
  at(centre, 2, 2, 2) = 1;
  EXPECT_DOUBLE_EQ(compare(centre, full).hd_directed_mm, 2);
}

TEST(Metrics, DifferentGridsAreRefused) {
  const Mask a = empty_mask({4, 4, 4});
  Mask moved = a, short_of_voxels = a;
  moved.geometry.origin_mm[0] = 1;
  short_of_voxels.voxels.pop_back();
  EXPECT_THROW(compare(a, empty_mask({4, 4, 5})), Error);
  EXPECT_THROW(compare(a, moved), Error);
  EXPECT_THROW(compare(a, short_of_voxels), Error);
  EXPECT_THROW(dice(a, moved), Error);
}

TEST(MaskOf, PicksOneLabelOrAll) {
  VolumeGeometry g;
  g.size = {6, 1, 1};
  g.origin_mm = {1, 2, 3};
  Volume labels(g, VoxelType::Int16);
  const std::int16_t values[] = {0, 1, 2, -1, 2, 300};
  std::copy(std::begin(values), std::end(values), labels.voxels<std::int16_t>().begin());
  using Voxels = std::vector<std::uint8_t>;
  EXPECT_EQ(mask_of(labels, std::nullopt).voxels, (Voxels{0, 1, 1, 1, 1, 1}));
  EXPECT_EQ(mask_of(labels, 2).voxels, (Voxels{0, 0, 1, 0, 1, 0}));
  EXPECT_EQ(mask_of(labels, 0).voxels, (Voxels{1, 0, 0, 0, 0, 0}));
  EXPECT_EQ(mask_of(labels, -1).voxels, (Voxels{0, 0, 0, 1, 0, 0}));
  // A label that the voxel type cannot represent matches no voxel; 65535 must not wrap around to -1.
  EXPECT_EQ(mask_of(labels, 65535).voxels, Voxels(6));
  EXPECT_EQ(mask_of(labels, 1.5).voxels, Voxels(6));
  EXPECT_EQ(mask_of(labels, std::nan("")).voxels, Voxels(6));
  EXPECT_TRUE(mask_of(labels, 2).geometry.same_grid(g));

  Volume real(g, VoxelType::Float32);
  real.voxels<float>()[1] = std::numeric_limits<float>::quiet_NaN();
  real.voxels<float>()[2] = 0.5f;
  EXPECT_EQ(mask_of(real, std::nullopt).voxels, (Voxels{0, 0, 1, 0, 0, 0}));
  EXPECT_EQ(mask_of(real, 0.5).voxels, (Voxels{0, 0, 1, 0, 0, 0}));
}

}  // namespace
}  // namespace simplexseg
