// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nifti_geometry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "io/source/stored_header.h"
#include "io/source/volume_source.h"

namespace simplexseg {
namespace {

/// Largest distance between the positions of a grid corner according to two transforms, in the header's unit.
double max_shift(const Eigen::Matrix<double, 3, 4>& a, const Eigen::Matrix<double, 3, 4>& b,
                 const std::array<int, 3>& n) {
  double shift = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector4d index(corner & 1 ? n[0] - 1 : 0, corner & 2 ? n[1] - 1 : 0, corner & 4 ? n[2] - 1 : 0, 1);
    shift = std::max(shift, ((a - b) * index).norm());
  }
  return shift;
}

bool invertible(const Eigen::Matrix<double, 3, 4>& m) {
  const Eigen::Matrix3d a = m.leftCols<3>();
  return m.allFinite() && std::abs(a.determinant()) > 1e-6 * a.colwise().norm().prod();
}

/// Rotation matrix of the quaternion in a header; the third column is negated if qfac (pixdim[0]) is below 0.
Eigen::Matrix3d rotation_of(const NiftiHeader& h) {
  double b = h.quaternion[0], c = h.quaternion[1], d = h.quaternion[2];
  double a2 = 1 - (b * b + c * c + d * d);
  if (a2 < 1e-7) {  // rotation by 180 degrees, up to rounding
    const double scale = 1 / std::sqrt(b * b + c * c + d * d);
    b *= scale, c *= scale, d *= scale, a2 = 0;
  }
  Eigen::Matrix3d rotation = Eigen::Quaterniond(std::sqrt(a2), b, c, d).toRotationMatrix();
  if (h.pixdim[0] < 0) rotation.col(2) *= -1;
  return rotation;
}

double millimetres_per_unit(const NiftiHeader& h) {
  switch (h.units & kNiftiLengthUnits) {
    case 1:
      return 1000;
    case 3:
      return 1e-3;
    default:
      return 1;
  }
}

NiftiFrame frame_of(const NiftiHeader& h) {
  NiftiFrame frame{.version = std::max(h.version, 1),
                   .qform_code = h.qform_code,
                   .sform_code = h.sform_code,
                   .units = h.units & kNiftiLengthUnits,
                   .quaternion = h.quaternion,
                   .qoffset = h.qoffset};
  std::copy_n(h.pixdim.begin(), frame.pixdim.size(), frame.pixdim.begin());
  for (std::size_t n = 0; n < frame.srow.size(); ++n)
    frame.srow[n] = h.srow(static_cast<Eigen::Index>(n / 4), static_cast<Eigen::Index>(n % 4));
  return frame;
}

}  // namespace

void set_geometry(const NiftiHeader& h, VolumeInfo& info) {
  VolumeGeometry& geometry = info.geometry;
  const double mm = millimetres_per_unit(h);
  Eigen::Vector3d spacing(1, 1, 1);
  for (int a = 0; a < 3; ++a) {
    const double size = std::abs(h.pixdim[a + 1]);
    if (size > 0) spacing[a] = size;  // NaN leaves 1: the other axes and the sform may be valid
    if (!(size > 0) && geometry.size[a] > 1) {
      if (h.sform_code <= 0)
        info.warnings.push_back("the header has no voxel size along axis " + std::to_string(a + 1) +
                                ": 1 mm is assumed");
    }
  }
  using Affine = Eigen::Matrix<double, 3, 4>;
  Affine qform = Affine::Zero();
  qform.leftCols<3>() = rotation_of(h) * spacing.asDiagonal();
  qform.col(3) = Eigen::Vector3d(h.qoffset[0], h.qoffset[1], h.qoffset[2]);
  const bool has_q = h.qform_code > 0 && invertible(qform);
  const bool has_s = h.sform_code > 0 && invertible(h.srow);
  if ((h.qform_code > 0 && !has_q) || (h.sform_code > 0 && !has_s)) {
    info.warnings.push_back(std::string("the header's ") + (h.sform_code > 0 && !has_s ? "sform" : "qform") +
                            " is singular or not finite and is ignored");
  }
  for (int a = 0; a < 3 && has_q && !has_s; ++a) {
    if (h.pixdim[a + 1] < 0)
      info.warnings.push_back("the header's voxel size along axis " + std::to_string(a + 1) +
                              " is negative, which NIfTI does not allow: its sign is ignored");
  }
  if (!has_q && !has_s) {
    // Method 1 of NIfTI, x = pixdim * i: origin 0 and the axes of LPS, reversed by a negative size, as in ITK.
    for (int a = 0; a < 3; ++a) geometry.set_step(a, h.pixdim[a + 1] < 0 ? -spacing[a] : spacing[a]);
    info.warnings.push_back("the header has no orientation: the patient's left and right are unknown");
  } else {
    // If both are valid but differ, the sform is used, as in nibabel and SPM. (ITK 5.2 uses the qform unless the code
    // of the sform is 1; several atlases have a valid sform and a qform that is mirrored or lacks its offsets.)
    if (has_q && has_s) {
      const double shift = max_shift(qform, h.srow, geometry.size);
      if (shift > 0.1 * spacing.minCoeff()) {
        info.warnings.push_back("the sform and the qform of the header are up to " + length_text(shift * mm) +
                                " apart: the sform is used, other programs may use the qform");
      }
    }
    const Affine& affine = has_s ? h.srow : qform;
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d column = kLpsFromRas.cwiseProduct(affine.col(a));
      const double length = column.norm();
      // The matrix rounds the voxel size, pixdim contains it exactly: pixdim is preferred if both agree.
      geometry.spacing_mm[a] = std::abs(length - spacing[a]) <= 1e-4 * spacing[a] ? spacing[a] : length;
      geometry.direction.col(a) = column / length;
    }
    geometry.origin_mm = kLpsFromRas.cwiseProduct(affine.col(3));
  }
  if (mm != 1) {
    geometry.spacing_mm *= mm;
    geometry.origin_mm *= mm;
    info.warnings.push_back(mm > 1 ? "lengths are in metres in the file" : "lengths are in micrometres in the file");
  }
  keep_header(geometry, frame_of(h));
}

}  // namespace simplexseg
