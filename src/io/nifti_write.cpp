// SPDX-License-Identifier: Apache-2.0
#include "io/nifti_write.h"

#include <zlib.h>

#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cerrno>
#include <cstring>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/error.h"
#include "image/volume.h"
#include "io/files.h"
#include "io/volume_source.h"

namespace simplexseg {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "the writer stores the machine's own byte order");

namespace {

bool orthogonal(const Eigen::Matrix3d& direction) {
  return (direction.transpose() * direction - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-4;
}

}  // namespace

void write_nifti(const fs::path& path, const Volume& volume) {
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

  const bool packed = extension_of(path) == ".nii.gz";
  const auto close = [](gzFile file) { gzclose(file); };
  std::unique_ptr<gzFile_s, decltype(close)> file(gzopen(path.c_str(), packed ? "wb4" : "wbT"), close);
  if (!file) throw std::runtime_error(std::strerror(errno));
  gzbuffer(file.get(), 1 << 18);
  const auto write = [&](const void* data, std::size_t size) {
    for (const char* from = static_cast<const char*>(data); size > 0;) {
      const unsigned chunk = static_cast<unsigned>(std::min<std::size_t>(size, 1u << 30));
      if (gzwrite(file.get(), from, chunk) != static_cast<int>(chunk)) throw std::runtime_error("the write failed");
      from += chunk;
      size -= chunk;
    }
  };
  write(bytes.data(), bytes.size());
  write(volume.data(), volume.bytes());
  if (gzclose(file.release()) != Z_OK) throw std::runtime_error("the write failed");
}

}  // namespace simplexseg
