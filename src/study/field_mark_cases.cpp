// SPDX-License-Identifier: Apache-2.0
// Stability cases of the evidence field: marks.
#include <cmath>
#include <limits>

#include "study/field_trials.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

/// Trial of the usual ball with the same marks in one update.
FieldTrial marked(std::vector<Mark> marks) {
  FieldTrial trial = trial_with(usual_grid(), ball);
  trial.updates = {std::move(marks)};
  return trial;
}
FieldCase refused(const char* name, const char* what, const char* text, const std::vector<Mark>& marks) {
  return trial_case(name, what, FieldOutcome::Refused, "with one line that names the mark and the fault", [=] {
    FieldTrial trial = marked(marks);
    trial.refusal_text = text;
    return trial;
  });
}
Shape everything() {
  return [](const Vector3d&) { return true; };
}
/// Places in the usual grid, the same on every machine.
std::vector<Vector3d> places(int count) {
  FieldNoise noise(7);
  std::vector<Vector3d> all;
  for (int n = 0; n < count; ++n) {
    Vector3d p;
    for (int a = 0; a < 3; ++a) p[a] = 46 * noise.uniform() - 23;
    all.push_back(p);
  }
  return all;
}

}  // namespace

std::vector<FieldCase> field_mark_cases() {
  const double nan = std::numeric_limits<double>::quiet_NaN(), infinite = std::numeric_limits<double>::infinity();
  const Mark seed = usual_seed();
  std::vector<FieldCase> cases;
  for (const bool large : {false, true}) {
    cases.push_back(
        trial_case(large ? "seed_1e6_in_coarse_cells" : "seed_over_everything",
                   large ? "radius of the seed 1e6 mm, 160^3 voxels" : "radius of the seed 1e6 mm, 48^3 voxels",
                   FieldOutcome::Found, "Dice with the volume at least .99: all cells are in the seed", [large] {
                     FieldTrial trial = trial_with(
                         large ? grid_of({160, 160, 160}) : usual_grid(), everything(),
                         [](const Vector3d& p, bool) { return usual_value(p, ball(p)); }, VoxelType::UInt8);
                     trial.updates = {{inside_mark({1, -0.5, 0.5}, 1e6)}};
                     trial.least_dice = 0.99;
                     return trial;
                   }));
  }
  cases.push_back(refused("seed_outside_volume", "the seed lies outside the volume", "outside the image",
                          {inside_mark({100, 0, 0}, 6)}));
  cases.push_back(refused("seed_not_finite", "the position of the seed is not a number", "outside the image",
                          {inside_mark({nan, 0, 0}, 6)}));
  cases.push_back(refused("seed_radius_0", "radius 0", "radius", {inside_mark({0, 0, 0}, 0)}));
  cases.push_back(refused("seed_radius_negative", "radius -1 mm", "radius", {inside_mark({0, 0, 0}, -1)}));
  cases.push_back(refused("seed_radius_infinite", "infinite radius", "radius", {inside_mark({0, 0, 0}, infinite)}));
  cases.push_back(refused("seed_radius_nan", "the radius is not a number", "radius", {inside_mark({0, 0, 0}, nan)}));
  cases.push_back(refused("no_marks", "no marks", "inside", {}));
  cases.push_back(refused("outside_marks_alone", "three outside marks", "inside",
                          {outside_mark({20, 0, 0}, 3), outside_mark({0, 20, 0}, 3), outside_mark({0, 0, 20}, 3)}));
  cases.push_back(refused("boundary_without_direction", "a boundary mark of direction 0", "direction",
                          {seed, boundary_mark({14, 0, 0}, 2, {0, 0, 0})}));
  cases.push_back(trial_case("seed_radius_1e-6", "radius of the seed 1e-6 mm", FieldOutcome::Bounded,
                             "the nearest voxel is marked; its object has at most twice the volume of the ball", [] {
                               FieldTrial trial = trial_without_object(
                                   usual_grid(), [](const Vector3d& p, bool) { return usual_value(p, ball(p)); });
                               trial.updates = {{inside_mark({0.5, 0.5, 0.5}, 1e-6)}};
                               trial.most_mm3 = 2 * ball_mm3(kFieldBallMm);
                               return trial;
                             }));
  cases.push_back(trial_case("contradiction_outside_last", "an inside and then an outside mark at the same place",
                             FieldOutcome::Empty, "the later mark counts, and no other is inside", [seed] {
                               return marked({seed, outside_mark(seed.position_mm, seed.radius_mm)});
                             }));
  cases.push_back(trial_case("contradiction_inside_last", "an outside and then an inside mark at the same place",
                             FieldOutcome::Found, "Dice at least .95: the later mark counts", [seed] {
                               return marked({outside_mark(seed.position_mm, seed.radius_mm), seed});
                             }));
  cases.push_back(trial_case("contradiction_in_object",
                             "the seed, then inside and outside marks of the same small ball in the object",
                             FieldOutcome::Found, "Dice at least .9: only the later one of the two counts", [seed] {
                               FieldTrial trial = marked({seed});
                               trial.updates.push_back({seed, inside_mark({0, 9, 0}, 2)});
                               trial.updates.push_back({seed, inside_mark({0, 9, 0}, 2), outside_mark({0, 9, 0}, 2)});
                               trial.least_dice = 0.9;
                               return trial;
                             }));
  cases.push_back(trial_case("contradictions_1000",
                             "1,000 marks at one place, inside and outside in turn, the last one inside",
                             FieldOutcome::Found, "Dice at least .95: the last one counts", [seed] {
                               std::vector<Mark> marks;
                               for (int m = 0; m < 500; ++m) {
                                 marks.push_back(outside_mark(seed.position_mm, seed.radius_mm));
                                 marks.push_back(seed);
                               }
                               return marked(std::move(marks));
                             }));
  cases.push_back(trial_case("marks_1000", "1,000 right marks of radius 1 mm, inside and outside", FieldOutcome::Found,
                             "Dice at least .95", [] {
                               std::vector<Mark> marks{usual_seed()};
                               for (const Vector3d& p : places(1000)) {
                                 if (std::abs(p.norm() - kFieldBallMm) < 1.5) continue;
                                 marks.push_back(ball(p) ? inside_mark(p, 1) : outside_mark(p, 1));
                               }
                               return marked(std::move(marks));
                             }));
  cases.push_back(trial_case(
      "marks_1000_wrong", "1,000 marks of radius 1 mm, inside or outside at random", FieldOutcome::Bounded,
      "the field is finite and keeps every mark that no later one covers", [] {
        FieldNoise noise(3);
        FieldTrial trial =
            trial_without_object(usual_grid(), [](const Vector3d& p, bool) { return usual_value(p, ball(p)); });
        std::vector<Mark> marks{usual_seed()};
        for (const Vector3d& p : places(1000))
          marks.push_back(noise.uniform() < 0.5 ? inside_mark(p, 1) : outside_mark(p, 1));
        trial.updates = {std::move(marks)};
        return trial;
      }));
  cases.push_back(trial_case("boundary_alone", "one boundary mark of radius 5 mm", FieldOutcome::Bounded,
                             "its inner half is the seed; the object has at most twice the volume of the ball", [] {
                               FieldTrial trial = trial_without_object(
                                   usual_grid(), [](const Vector3d& p, bool) { return usual_value(p, ball(p)); });
                               trial.updates = {{boundary_mark({14, 0, 0}, 5, {1, 0, 0})}};
                               trial.most_mm3 = 2 * ball_mm3(kFieldBallMm);
                               return trial;
                             }));
  cases.push_back(
      trial_case("boundaries_alone", "six boundary marks of radius 5 mm", FieldOutcome::Found, "Dice at least .9", [] {
        std::vector<Mark> marks;
        for (int a = 0; a < 3; ++a)
          for (const double side : {-1.0, 1.0})
            marks.push_back(boundary_mark(14 * side * Vector3d::Unit(a), 5, side * Vector3d::Unit(a)));
        FieldTrial trial = marked(std::move(marks));
        trial.least_dice = 0.9;
        return trial;
      }));
  cases.push_back(trial_case(
      "boundary_reversed", "the seed, and a boundary mark whose direction points into the object",
      FieldOutcome::Bounded, "the field is finite and keeps the seed", [seed] {
        FieldTrial trial =
            trial_without_object(usual_grid(), [](const Vector3d& p, bool) { return usual_value(p, ball(p)); });
        trial.updates = {{seed}, {seed, boundary_mark({14, 0, 0}, 2, {-1, 0, 0})}};
        return trial;
      }));
  cases.push_back(trial_case(
      "outside_over_everything", "an outside mark over the whole volume, then the seed", FieldOutcome::Found,
      "Dice with the seed at least .9: all cells are constrained", [seed] {
        FieldTrial trial = trial_with(
            usual_grid(), [seed](const Vector3d& p) { return (p - seed.position_mm).norm() <= seed.radius_mm; },
            [](const Vector3d& p, bool) { return usual_value(p, ball(p)); });
        trial.updates = {{outside_mark({0, 0, 0}, 100), seed}};
        trial.least_dice = 0.9;
        return trial;
      }));
  cases.push_back(trial_case(
      "others_over_everything", "an inside mark of another object over the whole volume", FieldOutcome::Found,
      "Dice with the seed at least .9: own marks precede those of others", [seed] {
        FieldTrial trial = trial_with(
            usual_grid(), [seed](const Vector3d& p) { return (p - seed.position_mm).norm() <= seed.radius_mm; },
            [](const Vector3d& p, bool) { return usual_value(p, ball(p)); });
        trial.updates = {{seed}};
        trial.others = {inside_mark({0, 0, 0}, 100)};
        trial.least_dice = 0.9;
        return trial;
      }));
  cases.push_back(
      trial_case("same_marks_20_times", "20 updates with the same seed and outside mark", FieldOutcome::Steady,
                 "a fixed point: after the second update no probability changes by more than .03 in an update", [seed] {
                   FieldTrial trial = marked({seed, outside_mark({0, 18, 0}, 2)});
                   trial.updates.resize(20, trial.updates.front());
                   trial.drift = 0.03;
                   return trial;
                 }));
  cases.push_back(trial_case("mark_on_and_off_10_times", "an outside mark that is added and removed ten times",
                             FieldOutcome::Found, "Dice at least .95 at the end", [seed] {
                               FieldTrial trial = marked({seed});
                               for (int n = 0; n < 10; ++n) {
                                 trial.updates.push_back({seed, outside_mark({0, 18, 0}, 2)});
                                 trial.updates.push_back({seed});
                               }
                               return trial;
                             }));
  cases.push_back(trial_case("seed_moved_10_times", "the seed moves by 1 mm ten times", FieldOutcome::Found,
                             "Dice at least .95 at the end", [] {
                               FieldTrial trial = marked({});
                               trial.updates.clear();
                               for (int n = 0; n < 10; ++n)
                                 trial.updates.push_back({inside_mark({n - 5.0, 0.5, 0.5}, 5)});
                               return trial;
                             }));
  return cases;
}

}  // namespace simplexseg
