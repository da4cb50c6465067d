// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nifti_write.h"

#include <Eigen/Geometry>
#include <bit>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "image/volume.h"
#include "io/platform/atomic_file.h"
#include "io/platform/compressing_writer.h"
#include "io/source/stored_header.h"
#include "io/source/volume_source.h"

namespace simplexseg {

static_assert(std::endian::native == std::endian::little, "the writer stores the machine's own byte order");

namespace {

constexpr int kDatatypes[] = {256, 2, 4, 512, 8, 768, 16, 64};  // in the order of VoxelType
constexpr std::size_t kExtensionBytes = 4;                      // zeros after the header: no extensions

/// Header bytes, written field by field.
class HeaderBytes {
 public:
  explicit HeaderBytes(std::size_t count) : bytes(count, '\0') {}

  template <class T>
  void put(std::size_t offset, double value) {
    const T stored = static_cast<T>(value);
    std::memcpy(&bytes[offset], &stored, sizeof stored);
  }
  template <class T, class Array>
  void put_all(std::size_t offset, const Array& values) {
    for (const double value : values) {
      put<T>(offset, value);
      offset += sizeof(T);
    }
  }

  std::string bytes;
};

/// Fields for a grid without a header: the sform, and the qform unless the grid is sheared, which a qform cannot state.
NiftiFrame frame_of(const VolumeGeometry& g) {
  NiftiFrame frame{.sform_code = 1, .units = 2, .pixdim = {1, g.spacing_mm[0], g.spacing_mm[1], g.spacing_mm[2]}};
  Eigen::Matrix3d rotation = kLpsFromRas.asDiagonal() * g.direction;
  const Eigen::Matrix3d linear = rotation * g.spacing_mm.asDiagonal();
  const Eigen::Vector3d origin = kLpsFromRas.cwiseProduct(g.origin_mm);
  for (std::size_t n = 0; n < frame.srow.size(); ++n) {
    const auto row = static_cast<Eigen::Index>(n / 4), column = static_cast<Eigen::Index>(n % 4);
    frame.srow[n] = column < 3 ? linear(row, column) : origin[row];
  }
  const bool mirrored = rotation.determinant() < 0;
  if (mirrored) rotation.col(2) *= -1;
  Eigen::Quaterniond q(rotation);
  q.normalize();
  if (q.w() < 0) q.coeffs() *= -1;
  VolumeGeometry of_qform = g;
  of_qform.direction = kLpsFromRas.asDiagonal() * q.toRotationMatrix();
  if (mirrored) of_qform.direction.col(2) *= -1;
  if (!of_qform.same_grid(g)) return frame;
  frame.qform_code = 1;
  if (mirrored) frame.pixdim[0] = -1;
  frame.quaternion = {q.x(), q.y(), q.z()};
  frame.qoffset = {origin[0], origin[1], origin[2]};
  return frame;
}

HeaderBytes header_of_version_1(const VolumeGeometry& grid, VoxelType type, const NiftiFrame& frame) {
  constexpr std::size_t size = 348;
  HeaderBytes header(size + kExtensionBytes);
  header.put<std::int32_t>(0, size);
  header.bytes[38] = 'r';
  header.put_all<std::int16_t>(40, std::array{3, 1, 1, 1, 1, 1, 1, 1});
  for (std::size_t a = 0; a < 3; ++a) {
    const int voxels = grid.size[a];
    if (voxels > 32767) {
      throw Error("cannot write a NIfTI file",
                  "NIfTI-1 allows 32767 voxels along an axis, this volume has " + std::to_string(voxels),
                  "save it as .nrrd");
    }
    header.put<std::int16_t>(42 + 2 * a, voxels);
  }
  header.put<std::int16_t>(70, kDatatypes[static_cast<int>(type)]);
  header.put<std::int16_t>(72, static_cast<double>(8 * bytes_per_voxel(type)));
  header.put_all<float>(76, frame.pixdim);
  header.put_all<float>(92, std::array{1, 1, 1, 1});
  header.put<float>(108, size + kExtensionBytes);
  header.put<float>(112, 1);
  header.bytes[123] = static_cast<char>(frame.units);
  header.put<std::int16_t>(252, frame.qform_code);
  header.put<std::int16_t>(254, frame.sform_code);
  header.put_all<float>(256, frame.quaternion);
  header.put_all<float>(268, frame.qoffset);
  header.put_all<float>(280, frame.srow);
  std::memcpy(&header.bytes[344], "n+1", 4);
  return header;
}

std::string header_of_version_2(const Volume& volume, const NiftiFrame& frame) {
  constexpr std::size_t size = 540;
  HeaderBytes header(size + kExtensionBytes);
  header.put<std::int32_t>(0, size);
  std::memcpy(&header.bytes[4], "n+2\0\r\n\032\n", 8);
  header.put<std::int16_t>(12, kDatatypes[static_cast<int>(volume.type())]);
  header.put<std::int16_t>(14, static_cast<double>(8 * bytes_per_voxel(volume.type())));
  header.put_all<std::int64_t>(16, std::array{3, 1, 1, 1, 1, 1, 1, 1});
  header.put_all<std::int64_t>(24, volume.geometry().size);
  header.put_all<double>(104, frame.pixdim);
  header.put_all<double>(136, std::array{1, 1, 1, 1});
  header.put<std::int64_t>(168, size + kExtensionBytes);
  header.put<double>(176, 1);
  header.put<std::int32_t>(344, frame.qform_code);
  header.put<std::int32_t>(348, frame.sform_code);
  header.put_all<double>(352, frame.quaternion);
  header.put_all<double>(376, frame.qoffset);
  header.put_all<double>(400, frame.srow);
  header.put<std::int32_t>(500, frame.units);
  return header.bytes;
}

/// Writes parts of memory one after the other, with `compress` as a gzip stream.
void write_parts(AtomicFile& file, bool compress, std::initializer_list<std::pair<const void*, std::size_t>> parts) {
  if (!compress) {
    for (const auto& [from, bytes] : parts) file.write(from, bytes);
    return;
  }
  CompressingWriter writer(file, CompressingWriter::Frame::Gzip);
  for (const auto& [from, bytes] : parts) writer.write(from, bytes);
  writer.finish();
}

}  // namespace

void write_nifti(AtomicFile& file, const Volume& volume, bool compress) {
  const NiftiFrame* const stored = stored_frame<NiftiFrame>(volume.geometry());
  const NiftiFrame frame = stored ? *stored : frame_of(volume.geometry());
  const std::string header = frame.version == 2 ? header_of_version_2(volume, frame)
                                                : header_of_version_1(volume.geometry(), volume.type(), frame).bytes;
  write_parts(file, compress, {{header.data(), header.size()}, {volume.data(), volume.bytes()}});
}

void write_nifti_vectors(AtomicFile& file, const VolumeGeometry& grid, const std::vector<Eigen::Vector3f>& vectors,
                         bool compress) {
  HeaderBytes header = header_of_version_1(grid, VoxelType::Float32, frame_of(grid));
  header.put_all<std::int16_t>(40, std::array{5, grid.size[0], grid.size[1], grid.size[2], 1, 3});
  header.put<std::int16_t>(68, 1007);
  std::array<std::vector<float>, 3> components;
  for (Eigen::Index c = 0; c < 3; ++c) {
    std::vector<float>& component = components[static_cast<std::size_t>(c)];
    component.reserve(vectors.size());
    for (const Eigen::Vector3f& vector : vectors) component.push_back(vector[c]);
  }
  const std::size_t bytes = vectors.size() * sizeof(float);
  write_parts(file, compress,
              {{header.bytes.data(), header.bytes.size()},
               {components[0].data(), bytes},
               {components[1].data(), bytes},
               {components[2].data(), bytes}});
}

}  // namespace simplexseg
