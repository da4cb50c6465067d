// SPDX-License-Identifier: Apache-2.0
// Stability cases: volumes with extreme voxels, grids and images.
#include <cmath>

#include "study/trials.h"

namespace simplexseg {
namespace {

constexpr auto kInfiniteVoxel = std::numeric_limits<double>::infinity();

/// Smoothing and the image forces gradient and evidence.
ForceParameters image_forces() {
  return forces_with({{"smoothing", "weight", 0.5f}, {"gradient", "weight", 0.2f}, {"evidence", "weight", 0.5f}});
}

bool in_ball(const Eigen::Vector3d& p) { return p.norm() < kBallRadius; }

Trial trial_in(const Volume& volume, const ForceParameters& forces) {
  Trial trial = trial_of(make_sphere({1, -0.5, 0.5}, 15, 2), volume, forces);
  trial.steps = 200;
  return trial;
}

/// Case with an uninformative image: no image force acts, and only smoothing moves the sphere.
StabilityCase uninformative(const char* name, const char* what, const char* reason,
                            const std::function<Volume()>& volume) {
  return {name,
          what,
          CaseOutcome::Converges,
          CaseOutcome::Converges,
          std::string("to the start, within 1 mm: ") + reason,
          [volume](bool) {
            Trial trial = trial_in(volume(), image_forces());
            set_value(trial.scene.meshes[0].parameters, {"smoothing", "curvature", 1});
            trial.error = distance_from(trial.scene.meshes[0].mesh);
            trial.tolerance = 1;
            return trial;
          }};
}
StabilityCase ball_in(const char* name, const char* what, CaseOutcome stated, const char* reason, VoxelType type,
                      const std::function<double(const Eigen::Vector3d&)>& value) {
  return {name, what, stated, stated, reason, [=](bool) {
            Trial trial = trial_in(volume_of(type, {32, 32, 32}, {2, 2, 2}, value), usual_forces());
            // Without an image force, smoothing has to preserve the volume.
            if (stated == CaseOutcome::Bounded)
              set_value(trial.scene.meshes[0].parameters, {"smoothing", "curvature", 1});
            trial.steps = 400;
            trial.error = radial_error(kBallRadius);
            trial.tolerance = 1.5;
            return trial;
          }};
}

/// Largest radial error of the vertices with x > 5 mm, mm.
double error_of_one_half(const Scene& end) {
  double largest = 0;
  for (const Eigen::Vector3f& p : end.meshes[0].mesh.positions)
    if (p[0] > 5) largest = std::max(largest, std::abs(p.cast<double>().norm() - kBallRadius));
  return largest;
}

}  // namespace

std::vector<StabilityCase> volume_cases() {
  std::vector<StabilityCase> cases;
  const auto fill = [](double value, VoxelType type = VoxelType::Float32) {
    return [=] { return volume_of(type, {32, 32, 32}, {2, 2, 2}, [value](const Eigen::Vector3d&) { return value; }); };
  };
  cases.push_back(uninformative("volume_constant", "one intensity", "no edge and no contrast", fill(100)));
  cases.push_back(
      uninformative("volume_zero", "all voxels 0, uint8", "no edge and no contrast", fill(0, VoxelType::UInt8)));
  cases.push_back(uninformative("volume_nan", "no voxel is a number", "none counts", fill(NAN)));
  cases.push_back(uninformative("volume_infinite", "all voxels infinite", "none counts", fill(kInfiniteVoxel)));
  cases.push_back(uninformative("volume_1e300", "float64 voxels of 1e300", "none is a number in float, so none counts",
                                fill(1e300, VoxelType::Float64)));
  cases.push_back(uninformative("volume_one_voxel", "a single voxel of 64 mm", "no edge and no contrast", [] {
    return volume_of(VoxelType::Int16, {1, 1, 1}, {64, 64, 64}, [](const Eigen::Vector3d&) { return 100.0; });
  }));
  cases.push_back({"volume_none", "no volume at all", CaseOutcome::Converges, CaseOutcome::Converges,
                   "to the start, within 1 mm: image forces are left out", [](bool) {
                     Trial trial = trial_in(Volume(), image_forces());
                     set_value(trial.scene.meshes[0].parameters, {"smoothing", "curvature", 1});
                     trial.error = distance_from(trial.scene.meshes[0].mesh);
                     trial.tolerance = 1;
                     return trial;
                   }});
  cases.push_back({"volume_single_slice", "32 x 32 x 1 voxels, 2 mm thick", CaseOutcome::Bounded, CaseOutcome::Bounded,
                   "only a ring of vertices sees the slice, the rest sees the outside", [](bool) {
                     Trial trial =
                         trial_in(volume_of(VoxelType::Int16, {32, 32, 1}, {2, 2, 2},
                                            [](const Eigen::Vector3d& p) { return in_ball(p) ? 150.0 : 50.0; }),
                                  image_forces());
                     set_value(trial.scene.meshes[0].parameters, {"smoothing", "curvature", 1});
                     trial.folds = true;
                     return trial;
                   }});
  cases.push_back({"voxels_0.05_0.05_10_mm", "voxels of 0.05 x 0.05 x 10 mm", CaseOutcome::Bounded,
                   CaseOutcome::Bounded, "the shortest side is the unit of pulls: slow, not unstable", [](bool full) {
                     const int n = full ? 480 : 240;
                     Trial trial = trial_of(
                         make_sphere({0, 0, 0}, n / 60.0, 2),
                         volume_of(VoxelType::Int16, {n, n, 4}, {0.05, 0.05, 10},
                                   [n](const Eigen::Vector3d& p) { return p.norm() < n / 50.0 ? 150.0 : 50.0; }),
                         usual_forces());
                     trial.reach_mm = 25;
                     return trial;
                   }});
  cases.push_back(ball_in("volume_int32_extremes", "object 2147483647, background -2147483648", CaseOutcome::Converges,
                          "to the ball's surface within 1.5 mm: differences are taken in float", VoxelType::Int32,
                          [](const Eigen::Vector3d& p) { return in_ball(p) ? 2147483647.0 : -2147483648.0; }));
  cases.push_back(ball_in("volume_uint32_extremes", "object 4294967295, background 0", CaseOutcome::Converges,
                          "to the ball's surface within 1.5 mm", VoxelType::UInt32,
                          [](const Eigen::Vector3d& p) { return in_ball(p) ? 4294967295.0 : 0.0; }));
  cases.push_back(ball_in("volume_float_extremes", "object 3e38, background -3e38", CaseOutcome::Bounded,
                          "differences exceed a float, so samples between do not count", VoxelType::Float32,
                          [](const Eigen::Vector3d& p) { return in_ball(p) ? 3e38 : -3e38; }));
  cases.push_back(ball_in("volume_tiny_contrast", "object 1e-30, background 0", CaseOutcome::Converges,
                          "to the ball's surface within 1.5 mm: intensities are taken in shares of their range",
                          VoxelType::Float32, [](const Eigen::Vector3d& p) { return in_ball(p) ? 1e-30 : 0.0; }));
  cases.push_back(ball_in("volume_large_offset", "object 1e6 + 100, background 1e6", CaseOutcome::Converges,
                          "to the ball's surface within 1.5 mm", VoxelType::Float32,
                          [](const Eigen::Vector3d& p) { return in_ball(p) ? 1e6 + 100 : 1e6; }));
  cases.push_back(ball_in("volume_infinite_object", "object infinite, background 50", CaseOutcome::Bounded,
                          "infinite voxels do not count", VoxelType::Float32,
                          [](const Eigen::Vector3d& p) { return in_ball(p) ? kInfiniteVoxel : 50.0; }));
  cases.push_back(ball_in("volume_nan_background", "object 150, background not a number", CaseOutcome::Bounded,
                          "what is not a number is taken for the outside of the volume", VoxelType::Float32,
                          [](const Eigen::Vector3d& p) { return in_ball(p) ? 150.0 : NAN; }));
  cases.push_back(ball_in("volume_nan_checkered", "every second voxel is not a number", CaseOutcome::Bounded,
                          "no sample has eight voxels to be mixed from", VoxelType::Float32,
                          [](const Eigen::Vector3d& p) {
                            const int parity = static_cast<int>(std::lround((p[0] + p[1] + p[2] + 93) / 2));
                            return parity % 2 ? NAN : in_ball(p) ? 150.0 : 50.0;
                          }));
  for (const bool nan : {true, false})
    cases.push_back(
        {nan ? "half_of_surface_nan" : "half_of_surface_flat",
         nan ? "voxels with x < 0 are not numbers" : "voxels with x < 0 are one intensity",
         nan ? CaseOutcome::Bounded : CaseOutcome::Bounded, nan ? CaseOutcome::Bounded : CaseOutcome::Bounded,
         "one half is held by the image, the other by smoothing alone", [nan](bool) {
           Trial trial = trial_in(volume_of(VoxelType::Float32, {32, 32, 32}, {2, 2, 2},
                                            [nan](const Eigen::Vector3d& p) {
                                              return p[0] < 0 ? (nan ? NAN : 100.0) : in_ball(p) ? 150.0 : 50.0;
                                            }),
                                  usual_forces());
           trial.steps = 600;
           trial.error = error_of_one_half;
           trial.tolerance = 1.5;
           return trial;
         }});
  return cases;
}

}  // namespace simplexseg
