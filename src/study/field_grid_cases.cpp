// SPDX-License-Identifier: Apache-2.0
// Stability cases of the evidence field: numbers of voxels, spacings and directions.
#include <cmath>
#include <utility>

#include "core/error.h"
#include "study/field_trials.h"

namespace simplexseg {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Case of a ball that is found with the usual seed, in a scaled world: grid, ball and seed are `mm` times as large.
FieldCase scaled(const char* name, const char* what, double mm) {
  return trial_case(name, what, FieldOutcome::Found, "Dice at least .95: lengths enter by ratios alone", [=] {
    FieldTrial trial =
        trial_with(grid_of({48, 48, 48}, {mm, mm, mm}), [mm](const Vector3d& p) { return ball(p / mm); });
    trial.updates = {{inside_mark(mm * usual_seed().position_mm, mm * usual_seed().radius_mm)}};
    return trial;
  });
}
FieldCase directed(const char* name, const char* what, const Matrix3d& direction) {
  return trial_case(name, what, FieldOutcome::Found, "Dice at least .95: distances are those of the patient frame",
                    [=] {
                      FieldTrial trial = trial_with(grid_of({56, 56, 56}, {1, 1, 1}, direction), ball);
                      trial.updates = {{usual_seed()}};
                      return trial;
                    });
}
/// Cylinder along an axis through all of its few thick slices.
FieldCase thick(const char* name, const char* what, int axis, double fine_mm, double thick_mm, int slices) {
  return trial_case(name, what, FieldOutcome::Found, "Dice at least .9: thick axes are coupled weakly and not halved",
                    [=] {
                      std::array<int, 3> size{96, 96, 96};
                      Vector3d spacing(fine_mm, fine_mm, fine_mm);
                      size[axis] = slices, spacing[axis] = thick_mm;
                      FieldTrial trial = trial_with(grid_of(size, spacing), [=](const Vector3d& p) {
                        Vector3d across = p;
                        across[axis] = 0;
                        return across.norm() < 28 * fine_mm;
                      });
                      trial.updates = {{inside_mark(fine_mm * Vector3d(1, 1, 1), 12 * fine_mm)}};
                      trial.least_dice = 0.9;
                      return trial;
                    });
}
/// Ball cut by a volume of few slices or rows.
FieldCase flat(const char* name, const char* what, std::array<int, 3> size) {
  return trial_case(name, what, FieldOutcome::Found,
                    "Dice at least .95: an axis of one cell has no sides with constraints", [=] {
                      FieldTrial trial = trial_with(grid_of(size), ball);
                      trial.updates = {{inside_mark({0, 0, 0}, 6)}};
                      return trial;
                    });
}
/// Volume of 2^31 zero voxels whose memory is not touched until it is written.
FieldTrial huge_trial(const Mark& seed) {
  FieldTrial trial;
  trial.volume = Volume(grid_of({2048, 1024, 1024}, {0.5, 0.5, 0.5}), VoxelType::UInt8);
  trial.updates = {{seed}};
  return trial;
}
/// Case of a geometry that Volume refuses with a message that contains `text`.
FieldCase refused_grid(const char* name, const char* what, const char* text, const VolumeGeometry& grid) {
  return {name, what, FieldOutcome::Refused, "with one line that names the fault", [=](const FieldBackend&) {
            FieldCaseResult result;
            try {
              const Volume volume(grid, VoxelType::UInt8);
              result.note = "the grid was not refused";
            } catch (const Error& error) {
              result.note = error.what();
              if (result.note.find(text) != std::string::npos) result.outcome = FieldOutcome::Refused;
            }
            return result;
          }};
}

}  // namespace

std::vector<FieldCase> field_grid_cases() {
  std::vector<FieldCase> cases;
  cases.push_back(thick("spacing_1_100", "voxels of 0.5 x 0.5 x 50 mm, 3 slices", 2, 0.5, 50, 3));
  cases.push_back(thick("spacing_1_1e4", "voxels of 0.01 x 0.01 x 100 mm, 4 slices", 2, 0.01, 100, 4));
  cases.push_back(thick("spacing_1e4_1_1", "voxels of 100 x 0.01 x 0.01 mm, 4 planes", 0, 0.01, 100, 4));
  cases.push_back(
      thick("spacing_1e15", "voxels of 1e-9 x 1e-9 x 1e6 mm, 4 slices: conductances over 30 orders", 2, 1e-9, 1e6, 4));
  cases.push_back(scaled("spacing_1e-9", "voxels of 1e-9 mm, the smallest", 1e-9));
  cases.push_back(scaled("spacing_micrometre", "voxels of 1 micrometre", 1e-3));
  cases.push_back(scaled("spacing_metre", "voxels of 1 m", 1e3));
  cases.push_back(scaled("spacing_1e6", "voxels of 1e6 mm, the largest", 1e6));
  cases.push_back(trial_case(
      "origin_1e9", "origin 1e9 mm away", FieldOutcome::Found, "Dice at least .95: positions are in double", [] {
        const Vector3d shift(1e9, -1e9, 1e9);
        VolumeGeometry grid = usual_grid();
        grid.origin_mm += shift;
        FieldTrial trial = trial_with(grid, [=](const Vector3d& p) { return ball(p - shift); });
        trial.updates = {{inside_mark(usual_seed().position_mm + shift, usual_seed().radius_mm)}};
        return trial;
      }));
  cases.push_back(flat("one_slice", "64 x 64 x 1 voxels", {64, 64, 1}));
  cases.push_back(flat("one_plane_of_i", "1 x 64 x 64 voxels", {1, 64, 64}));
  cases.push_back(flat("two_slices", "64 x 64 x 2 voxels", {64, 64, 2}));
  cases.push_back(flat("one_row", "64 x 1 x 1 voxels", {64, 1, 1}));
  cases.push_back(trial_case("one_voxel", "a single voxel", FieldOutcome::Found, "Dice 1: the marked voxel", [] {
    FieldTrial trial = trial_with(grid_of({1, 1, 1}), ball);
    trial.updates = {{inside_mark({0, 0, 0}, 1)}};
    trial.least_dice = 1;
    return trial;
  }));
  cases.push_back(trial_case(
      "two_voxels", "two voxels, a mark in each", FieldOutcome::Found, "Dice 1: the voxel with the inside mark", [] {
        FieldTrial trial = trial_with(grid_of({2, 1, 1}), [](const Vector3d& p) { return p[0] < 0; });
        trial.updates = {{inside_mark({-0.5, 0, 0}, 0.4), outside_mark({0.5, 0, 0}, 0.4)}};
        trial.least_dice = 1;
        return trial;
      }));
  cases.push_back(trial_case("eight_voxels", "2 x 2 x 2 voxels, a seed in one of them", FieldOutcome::Bounded,
                             "the seed's voxel belongs to the object", [] {
                               FieldTrial trial = trial_without_object(grid_of({2, 2, 2}), [](const Vector3d& p, bool) {
                                 return p[0] + 2 * p[1] + 4 * p[2];
                               });
                               trial.updates = {{inside_mark({-0.5, -0.5, -0.5}, 0.4)}};
                               return trial;
                             }));
  Matrix3d shear = Matrix3d::Identity(), flip = Matrix3d::Identity();
  shear(0, 1) = 0.5, shear(1, 2) = -0.3;
  flip(2, 2) = -1;
  const Matrix3d turn = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  cases.push_back(directed("sheared", "axes sheared by 0.5 and 0.3", shear));
  cases.push_back(directed("flipped", "left-handed axes", flip));
  cases.push_back(directed("rotated", "axes rotated by 40 degrees", turn));
  cases.push_back(directed("permuted", "axes permuted", (Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished()));
  FieldCase huge = trial_case(
      "voxels_2e31", "2048 x 1024 x 1024 voxels, all 0", FieldOutcome::Bounded,
      "no edge: the object has at most the volume of a ball of four radii of the seed; the box is small", [] {
        FieldTrial trial = huge_trial(inside_mark({0, 0, 0}, 20));
        trial.most_mm3 = ball_mm3(80);
        return trial;
      });
  huge.large = true;
  cases.push_back(std::move(huge));
  FieldCase huge_seed = trial_case("voxels_2e31_seed_over_everything", "the same, radius of the seed 1e6 mm",
                                   FieldOutcome::Bounded, "coarse cells hold the whole volume", [] {
                                     return huge_trial(inside_mark({0, 0, 0}, 1e6));
                                   });
  huge_seed.large = true;
  cases.push_back(std::move(huge_seed));
  cases.push_back(
      refused_grid("voxels_2e62", "2^31 - 1 voxels along i and j", "voxels", grid_of({2147483647, 2147483647, 1})));
  cases.push_back(refused_grid("spacing_0", "spacing 0 along k", "spacing", grid_of({8, 8, 8}, {1, 1, 0})));
  return cases;
}

}  // namespace simplexseg
