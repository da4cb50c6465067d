// SPDX-License-Identifier: Apache-2.0
// Building blocks of the stability cases of the evidence field.
#pragma once
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "field/evidence_settings.h"
#include "field/marks.h"
#include "image/mask.h"
#include "image/volume.h"
#include "study/field_stability_case.h"

namespace simplexseg {

/// Updates of a field, and the criteria for their outcome.
struct FieldTrial {
  Volume volume;
  std::optional<Mask> truth;               ///< object to find; none: the outcome is not Found
  std::vector<std::vector<Mark>> updates;  ///< marks of each update
  std::vector<Mark> others;
  EvidenceSettings settings{};
  double least_dice = 0.95;
  double most_mm3 = std::numeric_limits<double>::infinity();
  double drift = 0;               ///< Steady: largest change of a probability after the second update; 0: not measured
  std::string refusal_text = {};  ///< part of the message of a refusal
};

/// Grid of voxels centred at the origin.
VolumeGeometry grid_of(std::array<int, 3> size, const Eigen::Vector3d& spacing_mm = {1, 1, 1},
                       const Eigen::Matrix3d& direction = Eigen::Matrix3d::Identity());

using Shape = std::function<bool(const Eigen::Vector3d& mm)>;
/// Value of a voxel at a position, inside or outside the object.
using Appearance = std::function<double(const Eigen::Vector3d& mm, bool inside)>;
/// Object 150, background 50.
double usual_value(const Eigen::Vector3d& mm, bool inside);

/// Trial whose object is a shape; without marks.
FieldTrial trial_with(const VolumeGeometry& grid, const Shape& shape, const Appearance& value = usual_value,
                      VoxelType type = VoxelType::Float32);
/// Trial without an object to find; without marks.
FieldTrial trial_without_object(const VolumeGeometry& grid, const Appearance& value,
                                VoxelType type = VoxelType::Float32);

inline constexpr double kFieldBallMm = 14;  ///< radius of ball()
bool ball(const Eigen::Vector3d& mm);
/// Grid of 48^3 voxels of 1 mm, which contains ball().
VolumeGeometry usual_grid();
/// Seed in ball(), radius 6 mm.
Mark usual_seed();

Mark inside_mark(const Eigen::Vector3d& mm, double radius_mm);
Mark outside_mark(const Eigen::Vector3d& mm, double radius_mm);
Mark boundary_mark(const Eigen::Vector3d& mm, double radius_mm, const Eigen::Vector3d& outward);
double ball_mm3(double radius_mm);

/// Random numbers of splitmix64, the same on every machine.
class FieldNoise {
 public:
  explicit FieldNoise(std::uint64_t seed = 1) : state_(seed) {}
  double uniform();  ///< in [0, 1)
  double normal();   ///< standard deviation 1, by the sum of 12 uniform numbers

 private:
  std::uint64_t state_;
};

/// Case that runs a trial.
FieldCase trial_case(std::string name, std::string what, FieldOutcome stated, std::string reason,
                     std::function<FieldTrial()> make);
FieldCaseResult run_trial(const FieldTrial& trial, const FieldBackend& backend);

}  // namespace simplexseg
