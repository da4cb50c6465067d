// SPDX-License-Identifier: Apache-2.0
// Stability cases of the evidence field: intensities.
#include <cmath>
#include <limits>

#include "study/field_trials.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;
constexpr double kInfinite = std::numeric_limits<double>::infinity(), kNan = std::numeric_limits<double>::quiet_NaN();
/// Largest volume of an object in an image without one: a ball of four radii of the seed.
constexpr double kSeedRadii = 4;

Appearance two_values(double inside, double outside) {
  return [=](const Vector3d&, bool in) { return in ? inside : outside; };
}
/// Case of a ball of these values that is found.
FieldCase found(const char* name, const char* what, const char* reason, VoxelType type, const Appearance& value,
                double least_dice = 0.95) {
  return trial_case(name, what, FieldOutcome::Found, reason, [=] {
    FieldTrial trial = trial_with(usual_grid(), ball, value, type);
    trial.updates = {{usual_seed()}};
    trial.least_dice = least_dice;
    return trial;
  });
}
/// Case of an image without an object to find.
FieldCase without_object(const char* name, const char* what, FieldOutcome stated, const char* reason, VoxelType type,
                         const std::function<Appearance()>& make) {
  return trial_case(name, what, stated, reason, [=] {
    FieldTrial trial = trial_without_object(usual_grid(), make(), type);
    trial.updates = {{usual_seed()}};
    trial.most_mm3 = ball_mm3(kSeedRadii * usual_seed().radius_mm);
    return trial;
  });
}
Appearance with_noise(double inside, double outside, double deviation) {
  return [=, noise = std::make_shared<FieldNoise>()](const Vector3d&, bool in) {
    return (in ? inside : outside) + deviation * noise->normal();
  };
}

}  // namespace

std::vector<FieldCase> field_image_cases() {
  constexpr auto kFloat = VoxelType::Float32, kDouble = VoxelType::Float64;
  constexpr auto kFound = "Dice at least .95: intensities are scaled to their range";
  constexpr auto kNothing = "no edge: the object has at most the volume of a ball of four radii of the seed";
  const auto constant = [](double value) { return [value] { return two_values(value, value); }; };
  std::vector<FieldCase> cases;
  cases.push_back(
      without_object("contrast_0", "one intensity, float32", FieldOutcome::Bounded, kNothing, kFloat, constant(100)));
  cases.push_back(without_object("contrast_0_uint8", "all voxels 0, uint8", FieldOutcome::Bounded, kNothing,
                                 VoxelType::UInt8, constant(0)));
  cases.push_back(found("contrast_1e-8", "object 1e-8, background 0", kFound, kFloat, two_values(1e-8, 0)));
  cases.push_back(found("contrast_1e8", "object 1e8, background 0", kFound, kFloat, two_values(1e8, 0)));
  cases.push_back(
      found("contrast_1e8_in_noise", "object 1e8, background 0, noise 1e7", kFound, kFloat, with_noise(1e8, 0, 1e7)));
  cases.push_back(without_object("contrast_1e-8_of_1", "half of the volume 1 + 1e-8, the rest 1, float64",
                                 FieldOutcome::Bounded,
                                 "equal in float: no edge, at most a ball of four radii of the seed", kDouble,
                                 [] { return [](const Vector3d& p, bool) { return p[0] > 0 ? 1 + 1e-8 : 1; }; }));
  cases.push_back(found("contrast_1e-30", "object 1e-30, background 0", kFound, kFloat, two_values(1e-30, 0)));
  cases.push_back(found("contrast_denormal", "object 1e-40, background 0", kFound, kFloat, two_values(1e-40, 0)));
  cases.push_back(
      found("offset_1e6", "object 1000100, background 1000000", kFound, kFloat, two_values(1000100, 1000000)));
  cases.push_back(found("one_voxel_1e8", "one voxel of the background is 1e8",
                        "Dice at least .95: percentiles of the intensities limit their range", kFloat,
                        [](const Vector3d& p, bool in) {
                          const bool one = (p - Vector3d(20.5, 20.5, 20.5)).norm() < 0.1;
                          return one ? 1e8 : usual_value(p, in);
                        }));
  cases.push_back(without_object("volume_nan", "no voxel is a number", FieldOutcome::Empty,
                                 "cells that are not finite belong to no object", kFloat, constant(kNan)));
  cases.push_back(without_object("volume_infinite", "all voxels infinite", FieldOutcome::Empty,
                                 "cells that are not finite belong to no object", kFloat, constant(kInfinite)));
  cases.push_back(without_object("volume_1e300", "float64 voxels of 1e300", FieldOutcome::Empty,
                                 "infinite in float, so no cell is finite", kDouble, constant(1e300)));
  cases.push_back(trial_case("half_nan", "half of the volume and of the ball is not a number", FieldOutcome::Found,
                             "Dice with the finite part at least .95", [] {
                               FieldTrial trial = trial_with(
                                   usual_grid(), [](const Vector3d& p) { return p[0] < 0 && ball(p); },
                                   [](const Vector3d& p, bool in) { return p[0] < 0 ? usual_value(p, in) : kNan; });
                               trial.updates = {{inside_mark({-6.5, 0.5, 0.5}, 4)}};
                               return trial;
                             }));
  cases.push_back(trial_case("half_nan_seed_in_nan", "half of the volume is not a number, and the seed lies in it",
                             FieldOutcome::Empty, "no cell of the seed is finite", [] {
                               FieldTrial trial = trial_without_object(
                                   usual_grid(), [](const Vector3d& p, bool) { return p[0] < 0 ? 50 : kNan; });
                               trial.updates = {{inside_mark({12.5, 0.5, 0.5}, 4)}};
                               return trial;
                             }));
  for (const bool many : {false, true}) {
    const double share = many ? 0.3 : 0.1;
    cases.push_back(trial_case(many ? "scattered_nan_30" : "scattered_nan_10",
                               many ? "30% of the voxels, at random, are not numbers; they are connected"
                                    : "10% of the voxels, at random, are not numbers",
                               FieldOutcome::Found,
                               many ? "Dice with the finite part of the ball at least .9"
                                    : "Dice at least .9: cells without conductance are holes, which are filled",
                               [=] {
                                 FieldNoise noise;
                                 FieldTrial trial = trial_with(usual_grid(), ball, [&](const Vector3d& p, bool in) {
                                   return noise.uniform() < share ? kNan : usual_value(p, in);
                                 });
                                 if (many)
                                   for (std::size_t v = 0; v < trial.truth->voxels.size(); ++v)
                                     if (std::isnan(trial.volume.voxels<float>()[v])) trial.truth->voxels[v] = 0;
                                 trial.updates = {{usual_seed()}};
                                 trial.least_dice = 0.9;
                                 return trial;
                               }));
  }
  cases.push_back(without_object("nan_object", "the ball is not a number, the seed lies in it", FieldOutcome::Empty,
                                 "no cell of the seed is finite", kFloat,
                                 [] { return [](const Vector3d& p, bool) { return ball(p) ? kNan : 50; }; }));
  cases.push_back(found("nan_background", "object 150, background not a number",
                        "Dice at least .95: only the object is finite", kFloat, two_values(150, kNan)));
  cases.push_back(found("infinite_background", "object 150, background infinite",
                        "Dice at least .95: only the object is finite", kFloat, two_values(150, kInfinite)));
  cases.push_back(found("float_extremes", "object 3e38, background -3e38", kFound, kFloat, two_values(3e38, -3e38)));
  cases.push_back(found("double_beyond_float", "object 3, background 1e300 (infinite in float)",
                        "Dice at least .95: only the object is finite", kDouble, two_values(3, 1e300)));
  cases.push_back(found("int16_extremes", "object 32767, background -32768, int16", kFound, VoxelType::Int16,
                        two_values(32767, -32768)));
  cases.push_back(
      found("uint8_extremes", "object 255, background 0, uint8", kFound, VoxelType::UInt8, two_values(255, 0)));
  cases.push_back(
      found("uint8_contrast_1", "object 1, background 0, uint8", kFound, VoxelType::UInt8, two_values(1, 0)));
  cases.push_back(found("int32_extremes", "object 2147483647, background -2147483648, int32", kFound, VoxelType::Int32,
                        two_values(2147483647.0, -2147483648.0)));
  cases.push_back(found("uint32_extremes", "object 4294967295, background 0, uint32", kFound, VoxelType::UInt32,
                        two_values(4294967295.0, 0)));
  cases.push_back(without_object("noise_alone", "normal noise, deviation 25, no object", FieldOutcome::Bounded,
                                 kNothing, kFloat, [] { return with_noise(100, 100, 25); }));
  cases.push_back(found("noise_of_contrast", "normal noise whose deviation is the contrast",
                        "Dice at least .8 at the seed", kFloat, with_noise(150, 50, 100), 0.8));
  cases.push_back(trial_case("salt_and_pepper", "20% of the voxels are 0 or 200", FieldOutcome::Found,
                             "Dice at least .8 at the seed", [] {
                               FieldNoise noise;
                               FieldTrial trial = trial_with(usual_grid(), ball, [&](const Vector3d& p, bool in) {
                                 const double u = noise.uniform();
                                 return u < 0.1 ? 0 : u < 0.2 ? 200 : usual_value(p, in);
                               });
                               trial.updates = {{usual_seed()}};
                               trial.least_dice = 0.8;
                               return trial;
                             }));
  cases.push_back(without_object("checkerboard", "neighbours 0 and 100 in turn: every edge conducts 1e-5",
                                 FieldOutcome::Bounded, kNothing, kFloat, [] {
                                   return [](const Vector3d& p, bool) {
                                     return static_cast<int>(p[0] + p[1] + p[2] + 300) % 2 == 0 ? 0.0 : 100.0;
                                   };
                                 }));
  cases.push_back(without_object("ramp", "intensity linear in x, no object", FieldOutcome::Bounded, kNothing, kFloat,
                                 [] { return [](const Vector3d& p, bool) { return p[0]; }; }));
  return cases;
}

}  // namespace simplexseg
