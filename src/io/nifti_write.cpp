// SPDX-License-Identifier: Apache-2.0
#include "io/nifti_write.h"

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "core/error.h"
#include "image/volume.h"
#include "io/atomic_file.h"
#include "io/packed_writer.h"
#include "io/volume_source.h"

namespace simplexseg {

static_assert(std::endian::native == std::endian::little, "the writer stores the machine's own byte order");

namespace {

bool orthogonal(const Eigen::Matrix3d& direction) {
  return (direction.transpose() * direction - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-4;
}

}  // namespace

void write_nifti(AtomicFile& file, const Volume& volume, bool packed) {
  const VolumeGeometry& g = volume.geometry();
  std::array<unsigned char, 352> bytes{};
  const auto put = [&]<class T>(std::size_t offset, T value) { std::memcpy(&bytes[offset], &value, sizeof value); };
  const int codes[] = {256, 2, 4, 512, 8, 768, 16, 64};  // in the order of VoxelType
  put(0, std::int32_t(348));
  bytes[38] = 'r';
  put(40, std::int16_t(3));
  for (int a = 0; a < 7; ++a) {
    const int size = a < 3 ? g.size[a] : 1;
    if (size > 32767) {
      throw Error("cannot write a NIfTI file",
                  "it holds at most 32767 voxels along an axis, these are " + std::to_string(size), "write .nrrd");
    }
    put(42 + 2 * a, std::int16_t(size));
    put(80 + 4 * a, a < 3 ? float(g.spacing_mm[a]) : 1.f);
  }
  put(70, std::int16_t(codes[static_cast<int>(volume.type())]));
  put(72, std::int16_t(8 * bytes_per_voxel(volume.type())));
  put(108, 352.f);
  put(112, 1.f);
  bytes[123] = 2;  // mm
  std::memcpy(&bytes[344], "n+1", 4);

  Eigen::Matrix3d rotation = kLpsFromRas.asDiagonal() * g.direction;
  const Eigen::Matrix3d linear = rotation * g.spacing_mm.asDiagonal();
  const Eigen::Vector3d origin = kLpsFromRas.cwiseProduct(g.origin_mm);
  put(254, std::int16_t(1));
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) put(280 + 16 * r + 4 * c, float(linear(r, c)));
    put(280 + 16 * r + 12, float(origin[r]));
  }
  put(76, 1.f);
  if (orthogonal(rotation)) {  // a sheared geometry has an sform only
    if (rotation.determinant() < 0) {
      rotation.col(2) *= -1;
      put(76, -1.f);
    }
    Eigen::Quaterniond q(rotation);
    q.normalize();
    if (q.w() < 0) q.coeffs() *= -1;
    put(252, std::int16_t(1));
    put(256, float(q.x()));
    put(260, float(q.y()));
    put(264, float(q.z()));
    for (int r = 0; r < 3; ++r) put(268 + 4 * r, float(origin[r]));
  }

  if (!packed) {
    file.write(bytes.data(), bytes.size());
    file.write(volume.data(), volume.bytes());
    return;
  }
  PackedWriter packer(file, PackedWriter::Frame::Gzip);
  packer.write(bytes.data(), bytes.size());
  packer.write(volume.data(), volume.bytes());
  packer.finish();
}

}  // namespace simplexseg
