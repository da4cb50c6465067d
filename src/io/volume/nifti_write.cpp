// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nifti_write.h"

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstring>
#include <string>

#include "core/error.h"
#include "image/volume.h"
#include "io/platform/atomic_file.h"
#include "io/platform/compressing_writer.h"
#include "io/source/volume_source.h"

namespace simplexseg {

static_assert(std::endian::native == std::endian::little, "the writer stores the machine's own byte order");

namespace {

bool orthogonal(const Eigen::Matrix3d& direction) {
  return (direction.transpose() * direction - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-4;
}

}  // namespace

void write_nifti(AtomicFile& file, const Volume& volume, bool compress) {
  const VolumeGeometry& g = volume.geometry();
  std::array<unsigned char, 352> bytes{};
  const auto store = [&]<class T>(std::size_t offset, T value) { std::memcpy(&bytes[offset], &value, sizeof value); };
  const int codes[] = {256, 2, 4, 512, 8, 768, 16, 64};  // in the order of VoxelType
  store(0, std::int32_t(348));
  bytes[38] = 'r';
  store(40, std::int16_t(3));
  for (int a = 0; a < 7; ++a) {
    const int size = a < 3 ? g.size[a] : 1;
    if (size > 32767) {
      throw Error("cannot write a NIfTI file",
                  "NIfTI-1 allows 32767 voxels along an axis, this volume has " + std::to_string(size),
                  "save it as .nrrd");
    }
    store(42 + 2 * a, std::int16_t(size));
    store(80 + 4 * a, a < 3 ? float(g.spacing_mm[a]) : 1.f);
  }
  store(70, std::int16_t(codes[static_cast<int>(volume.type())]));
  store(72, std::int16_t(8 * bytes_per_voxel(volume.type())));
  store(108, 352.f);
  store(112, 1.f);
  bytes[123] = 2;  // mm
  std::memcpy(&bytes[344], "n+1", 4);

  Eigen::Matrix3d rotation = kLpsFromRas.asDiagonal() * g.direction;
  const Eigen::Matrix3d linear = rotation * g.spacing_mm.asDiagonal();
  const Eigen::Vector3d origin = kLpsFromRas.cwiseProduct(g.origin_mm);
  store(254, std::int16_t(1));
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) store(280 + 16 * r + 4 * c, float(linear(r, c)));
    store(280 + 16 * r + 12, float(origin[r]));
  }
  store(76, 1.f);
  if (orthogonal(rotation)) {  // a qform cannot represent a sheared geometry
    if (rotation.determinant() < 0) {
      rotation.col(2) *= -1;
      store(76, -1.f);
    }
    Eigen::Quaterniond q(rotation);
    q.normalize();
    if (q.w() < 0) q.coeffs() *= -1;
    store(252, std::int16_t(1));
    store(256, float(q.x()));
    store(260, float(q.y()));
    store(264, float(q.z()));
    for (int r = 0; r < 3; ++r) store(268 + 4 * r, float(origin[r]));
  }

  if (!compress) {
    file.write(bytes.data(), bytes.size());
    file.write(volume.data(), volume.bytes());
    return;
  }
  CompressingWriter writer(file, CompressingWriter::Frame::Gzip);
  writer.write(bytes.data(), bytes.size());
  writer.write(volume.data(), volume.bytes());
  writer.finish();
}

}  // namespace simplexseg
