// SPDX-License-Identifier: Apache-2.0
// Stability cases of the evidence field: size and shape of the object, and objects that the volume cuts.
#include <algorithm>
#include <cmath>

#include "study/field_trials.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

FieldCase shape(const char* name, const char* what, const char* reason, double least_dice, const VolumeGeometry& grid,
                const Shape& object, const std::vector<Mark>& marks) {
  return trial_case(name, what, FieldOutcome::Found, reason, [=] {
    FieldTrial trial = trial_with(grid, object);
    trial.updates = {marks};
    trial.least_dice = least_dice;
    return trial;
  });
}
Shape ball_at(const Vector3d& centre, double radius) {
  return [=](const Vector3d& p) { return (p - centre).norm() < radius; };
}
Shape box_of(const Vector3d& half) {
  return [=](const Vector3d& p) { return (p.array().abs() < half.array()).all(); };
}

}  // namespace

std::vector<FieldCase> field_shape_cases() {
  const VolumeGeometry small = grid_of({33, 33, 33}), usual = usual_grid();
  std::vector<FieldCase> cases;
  cases.push_back(shape("object_1_voxel", "one bright voxel, seed radius 0.4 voxels",
                        "Dice at least .6: at most two voxels too many", 0.6, small, ball_at({0, 0, 0}, 0.5),
                        {inside_mark({0, 0, 0}, 0.4)}));
  cases.push_back(shape("object_3_voxels", "three bright voxels in a row, seed radius 0.4 voxels", "Dice at least .6",
                        0.6, small, box_of({1.2, 0.5, 0.5}), {inside_mark({0, 0, 0}, 0.4)}));
  cases.push_back(shape("object_27_voxels", "3 x 3 x 3 bright voxels, seed radius 1 voxel", "Dice at least .7", 0.7,
                        small, box_of({1.5, 1.5, 1.5}), {inside_mark({0, 0, 0}, 1)}));
  cases.push_back(shape("plate_1_voxel", "plate of 32 x 32 x 1 voxels, seed radius 0.4 voxels and eight inside marks",
                        "Dice at least .8", 0.8, grid_of({49, 49, 49}), box_of({16.5, 16.5, 0.5}), [] {
                          std::vector<Mark> marks;
                          for (int i = -1; i <= 1; ++i)
                            for (int j = -1; j <= 1; ++j) marks.push_back(inside_mark({10.0 * i, 10.0 * j, 0}, 0.4));
                          return marks;
                        }()));
  cases.push_back(shape("plate_3_voxels", "plate of 32 x 32 x 3 voxels, seed radius 1.5 voxels",
                        "Dice at least .8 at the seed", 0.8, grid_of({49, 49, 49}), box_of({16.5, 16.5, 1.5}),
                        {inside_mark({0, 0, 0}, 1.5)}));
  cases.push_back(shape("tube_3_voxels", "tube of radius 1.6 and length 40 voxels, seed radius 1.5 voxels",
                        "Dice at least .8 at the seed", 0.8, grid_of({49, 33, 33}),
                        [](const Vector3d& p) { return std::abs(p[0]) < 20.5 && std::hypot(p[1], p[2]) < 1.6; },
                        {inside_mark({0, 0, 0}, 1.5)}));
  cases.push_back(shape("shell_3_voxels", "shell of radius 14 and thickness 3 voxels, seed radius 1.5 voxels",
                        "Dice at least .8 at the seed", 0.8, grid_of({49, 49, 49}),
                        [](const Vector3d& p) { return p.norm() > 12.5 && p.norm() < 15.5; },
                        {inside_mark({14, 0, 0}, 1.5)}));
  cases.push_back(shape("cut_by_one_side", "half of the ball lies outside of the volume",
                        "Dice at least .95: sides of the volume do not erode the object", 0.95, usual,
                        ball_at({24, 0, 0}, 14), {inside_mark({18, 0.5, 0.5}, 5)}));
  cases.push_back(shape("cut_by_edge", "the ball's centre lies on an edge of the volume", "Dice at least .95", 0.95,
                        usual, ball_at({24, 24, 0}, 14), {inside_mark({19, 19, 0.5}, 4)}));
  cases.push_back(shape("cut_by_corner", "the ball's centre lies in a corner of the volume", "Dice at least .95", 0.95,
                        usual, ball_at({24, 24, 24}, 14), {inside_mark({20, 20, 20}, 3.5)}));
  cases.push_back(shape("tube_through_volume", "tube of radius 7 mm through two sides of the volume",
                        "Dice at least .95", 0.95, usual, [](const Vector3d& p) { return std::hypot(p[1], p[2]) < 7; },
                        {inside_mark({0, 0.5, 0.5}, 6)}));
  cases.push_back(shape("plate_through_volume", "plate of 10 mm through four sides of the volume", "Dice at least .95",
                        0.95, usual, [](const Vector3d& p) { return std::abs(p[2]) < 5; },
                        {inside_mark({0, 0.5, 0.5}, 4)}));
  cases.push_back(shape("all_but_a_corner", "the object is the volume without a ball in its corner",
                        "Dice at least .95 at the seed", 0.95, usual,
                        [](const Vector3d& p) { return (p - Vector3d(24, 24, 24)).norm() > 14; },
                        {inside_mark({-3, -3, -3}, 18)}));
  cases.push_back(trial_case(
      "open_wall", "seed in a shell that is open on half of its sphere, of the same intensity as the rest",
      FieldOutcome::Found, "Dice with the ball in the shell at least .8: the opening is closed by a short surface", [] {
        FieldTrial trial = trial_with(
            grid_of({128, 128, 128}), [](const Vector3d& p) { return p.norm() < 9; },
            [](const Vector3d& p, bool) {
              const double r = p.norm();
              return r > 9 && r < 12 && p[0] < 0 ? 50.0 : 150.0;
            });
        trial.updates = {{inside_mark({-2, 0.5, 0.5}, 6)}};
        trial.least_dice = 0.8;
        return trial;
      }));
  cases.push_back(trial_case(
      "half_space", "the object is half of the volume, and the small seed lies near its border", FieldOutcome::Stopped,
      "more than 16 balls of the scale of the seed: growth stops and reports it, with less than half of the volume",
      [] {
        FieldTrial trial = trial_without_object(grid_of({96, 96, 96}),
                                                [](const Vector3d& p, bool) { return p[0] < 4 ? 150.0 : 50.0; });
        trial.updates = {{inside_mark({0, 0.5, 0.5}, 3)}};
        trial.most_mm3 = 0.5 * 96 * 96 * 96;
        return trial;
      }));
  return cases;
}

}  // namespace simplexseg
