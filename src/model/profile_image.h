// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <Eigen/Geometry>
#include <vector>

#include "field/box_grid.h"
#include "field/run_jobs.h"
#include "image/volume.h"
#include "model/organ_model.h"

namespace simplexseg {

/// Half edge of the box of intensities, sizes of the mean shape.
inline constexpr double kProfileImageRadius = 2.5;

/// Smoothed and scaled intensities around an organ, on cells of about the distance of profile samples.
class ProfileImage {
 public:
  /// `centre_mm`: place in the organ, `radius_mm`: half edge of the box of intensities. The volume must not be empty.
  ProfileImage(const Volume& volume, const Eigen::Vector3d& centre_mm, double radius_mm, const ProfileModel& model,
               const RunJobs& run);

  /// Trilinear interpolation at a place (mm), clamped to the box.
  float sample(const Eigen::Vector3d& mm) const;
  /// Intensity of the volume for a value of sample().
  float intensity_of(float value) const { return low_ + unit_ * value; }
  /// Whether a place lies in the volume.
  bool is_in_volume(const Eigen::Vector3d& mm) const { return volume_.contains(mm); }
  /// Smallest edge of a cell, mm.
  double cell_mm() const { return cell_mm_; }

 private:
  VolumeGeometry volume_;
  BoxGrid grid_;
  std::vector<float> values_;
  Eigen::Affine3d index_from_world_;
  double cell_mm_;
  float low_ = 0, unit_ = 1;  // intensities of the values 0 and 1: low, low + unit
};

}  // namespace simplexseg
