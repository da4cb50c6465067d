// SPDX-License-Identifier: Apache-2.0
// NIfTI and Analyze, read without ITK: its reader refuses sheared sforms, fills what a truncated file lacks with zeros,
// knows no NIfTI-2 and copies the voxels; its writer makes a sheared geometry orthogonal.
// Format: https://nifti.nimh.nih.gov/pub/dist/src/niftilib/nifti1.h and nifti2.h.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <memory>
#include <vector>

#include "io/files.h"
#include "io/gz_file.h"
#include "io/volume_source.h"

namespace simplexseg {

namespace fs = std::filesystem;
static_assert(std::endian::native == std::endian::little, "the writer stores the machine's own byte order");

namespace {

constexpr const char* export_again = "copy or export the file again";
const Eigen::Vector3d lps_from_ras(-1, -1, 1);

struct Header {
  std::array<unsigned char, 540> bytes{};
  int version = 0;  ///< 0 Analyze, 1, 2
  bool swapped = false;
  bool single_file = false;
  std::array<std::int64_t, 8> dim{};
  std::array<double, 8> pixdim{};
  int datatype = 0, qform_code = 0, sform_code = 0, units = 0;
  double slope = 0, intercept = 0, vox_offset = 0;
  std::array<double, 3> quaternion{}, qoffset{};
  Eigen::Matrix<double, 3, 4> srow;

  template <class T>
  T at(std::size_t offset) const {
    std::array<unsigned char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes.data() + offset, sizeof(T));
    if (swapped) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  /// Fills the fields of `count` numbers of type T from `offset` on.
  template <class T, class Array>
  void fill(Array& to, std::size_t offset, std::size_t count) const {
    for (std::size_t i = 0; i < count; ++i) to[i] = at<T>(offset + i * sizeof(T));
  }
};

/// The header as numbers; version -1 when it is neither NIfTI nor Analyze.
Header parse(const std::array<unsigned char, 540>& bytes, std::size_t count) {
  Header h;
  h.bytes = bytes;
  h.version = -1;
  if (count < 348) return h;
  const auto has_magic = [&](std::size_t at, const char* magic) { return std::memcmp(&bytes[at], magic, 4) == 0; };
  for (const bool swapped : {false, true}) {
    h.swapped = swapped;
    const auto size = h.at<std::int32_t>(0);
    if (size == 540 && count >= 540 && (has_magic(4, "n+2\0") || has_magic(4, "ni2\0"))) {
      h.version = 2;
      h.single_file = bytes[5] == '+';
      break;
    }
    const bool nifti = has_magic(344, "n+1\0") || has_magic(344, "ni1\0");
    const auto rank = h.at<std::int16_t>(40);
    if (nifti ? rank >= 1 && rank <= 7 : size == 348) {
      h.version = nifti ? 1 : 0;
      h.single_file = nifti && bytes[345] == '+';
      break;
    }
  }
  if (h.version < 0) return h;
  std::array<double, 12> rows{};
  if (h.version == 2) {
    h.datatype = h.at<std::int16_t>(12);
    h.fill<std::int64_t>(h.dim, 16, 8);
    h.fill<double>(h.pixdim, 104, 8);
    h.vox_offset = static_cast<double>(h.at<std::int64_t>(168));
    h.slope = h.at<double>(176);
    h.intercept = h.at<double>(184);
    h.qform_code = h.at<std::int32_t>(344);
    h.sform_code = h.at<std::int32_t>(348);
    h.fill<double>(h.quaternion, 352, 3);
    h.fill<double>(h.qoffset, 376, 3);
    h.fill<double>(rows, 400, 12);
    h.units = h.at<std::int32_t>(500);
  } else {
    h.datatype = h.at<std::int16_t>(70);
    h.fill<std::int16_t>(h.dim, 40, 8);
    h.fill<float>(h.pixdim, 76, 8);
    h.vox_offset = h.at<float>(108);
    if (h.version == 1) {
      h.slope = h.at<float>(112);
      h.intercept = h.at<float>(116);
      h.qform_code = h.at<std::int16_t>(252);
      h.sform_code = h.at<std::int16_t>(254);
      h.fill<float>(h.quaternion, 256, 3);
      h.fill<float>(h.qoffset, 268, 3);
      h.fill<float>(rows, 280, 12);
      h.units = h.at<std::uint8_t>(123);
    }
  }
  h.srow = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(rows.data());
  return h;
}

Header read_header(GzReader& reader) {
  std::array<unsigned char, 540> bytes{};
  return parse(bytes, reader.read(bytes.data(), 348) == 348
                          ? 348 + (std::memcmp(&bytes[4], "n+2", 3) == 0 || std::memcmp(&bytes[4], "ni2", 3) == 0
                                       ? reader.read(&bytes[348], 192)
                                       : 0)
                          : 0);
}

/// What the numbers of `datatype` are: bytes each, and the type they are kept in. `wide` for 64-bit integers.
struct Stored {
  int bytes;
  VoxelType type;
  bool wide = false;
};

Stored stored_type(int datatype, const std::string& name) {
  switch (datatype) {
    case 2:
      return {1, VoxelType::UInt8};
    case 4:
      return {2, VoxelType::Int16};
    case 8:
      return {4, VoxelType::Int32};
    case 16:
      return {4, VoxelType::Float32};
    case 64:
      return {8, VoxelType::Float64};
    case 256:
      return {1, VoxelType::Int8};
    case 512:
      return {2, VoxelType::UInt16};
    case 768:
      return {4, VoxelType::UInt32};
    case 1024:
      return {8, VoxelType::Int32, true};
    case 1280:
      return {8, VoxelType::UInt32, true};
    default:
      break;
  }
  const char* kind = "of a type that is not known (code ";
  if (datatype == 128 || datatype == 2304) kind = "colours (code ";
  if (datatype == 32 || datatype == 1792 || datatype == 2048) kind = "complex numbers (code ";
  if (datatype == 1) kind = "single bits (code ";
  if (datatype == 1536) kind = "128-bit numbers (code ";
  throw Error("cannot read " + name, std::string("its voxels are ") + kind + std::to_string(datatype) + ")",
              "save it with one integer or float for each voxel");
}

double max_shift(const Eigen::Matrix<double, 3, 4>& a, const Eigen::Matrix<double, 3, 4>& b,
                 const std::array<int, 3>& n) {
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector4d index(corner & 1 ? n[0] - 1 : 0, corner & 2 ? n[1] - 1 : 0, corner & 4 ? n[2] - 1 : 0, 1);
    most = std::max(most, ((a - b) * index).norm());
  }
  return most;
}

bool invertible(const Eigen::Matrix<double, 3, 4>& m) {
  const Eigen::Matrix3d a = m.leftCols<3>();
  return m.allFinite() && std::abs(a.determinant()) > 1e-6 * a.colwise().norm().prod();
}

bool orthogonal(const Eigen::Matrix3d& direction) {
  return (direction.transpose() * direction - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-4;
}

/// The rotation of a NIfTI quaternion, third column turned round where qfac < 0.
Eigen::Matrix3d rotation_of(const Header& h) {
  double b = h.quaternion[0], c = h.quaternion[1], d = h.quaternion[2];
  double a2 = 1 - (b * b + c * c + d * d);
  if (a2 < 1e-7) {  // half a turn; the rest is rounding
    const double scale = 1 / std::sqrt(b * b + c * c + d * d);
    b *= scale, c *= scale, d *= scale, a2 = 0;
  }
  Eigen::Matrix3d rotation = Eigen::Quaterniond(std::sqrt(a2), b, c, d).toRotationMatrix();
  if (h.pixdim[0] < 0) rotation.col(2) *= -1;
  return rotation;
}

void set_geometry(const Header& h, VolumeInfo& info) {
  VolumeGeometry& geometry = info.geometry;
  Eigen::Vector3d spacing(1, 1, 1);
  for (int a = 0; a < 3; ++a) {
    const double size = std::abs(h.pixdim[a + 1]);
    if (size > 0) spacing[a] = size;  // NaN stays out too; the other axes and the sform may still be good
    if (!(size > 0) && geometry.size[a] > 1) {
      if (h.sform_code <= 0)
        info.warnings.push_back("the header gives no voxel size along axis " + std::to_string(a + 1) +
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
                            " cannot be used (singular or not finite) and is left out");
  }
  if (!has_q && !has_s) {
    geometry.spacing_mm = spacing;  // origin 0 and directions LPS, as ITK assumes
    info.warnings.push_back("the header gives no orientation: which side is the patient's left is not known");
  } else {
    // Where the two disagree the sform wins, as in nibabel and SPM. (ITK 5.2 takes the qform unless the sform's code is
    // 1; several atlases carry a qform without its offsets, or mirrored, beside a good sform.)
    if (has_q && has_s) {
      const double shift = max_shift(qform, h.srow, geometry.size);
      if (shift > 0.1 * spacing.minCoeff()) {
        char text[160];
        std::snprintf(text, sizeof text,
                      "the header holds two positions up to %.3g mm apart: the sform is used, other "
                      "programs may use the qform",
                      shift);
        info.warnings.push_back(text);
      }
    }
    const Affine& affine = has_s ? h.srow : qform;
    for (int a = 0; a < 3; ++a) {
      const Eigen::Vector3d column = lps_from_ras.cwiseProduct(affine.col(a));
      const double length = column.norm();
      // The voxel size is written twice; within rounding the plain number is the better one.
      geometry.spacing_mm[a] = std::abs(length - spacing[a]) <= 1e-4 * spacing[a] ? spacing[a] : length;
      geometry.direction.col(a) = column / length;
    }
    geometry.origin_mm = lps_from_ras.cwiseProduct(affine.col(3));
  }
  const int unit = h.units & 7;
  const double mm = unit == 1 ? 1000 : unit == 3 ? 1e-3 : 1;
  if (mm != 1) {
    geometry.spacing_mm *= mm;
    geometry.origin_mm *= mm;
    info.warnings.push_back(unit == 1 ? "lengths are in metres in the file" : "lengths are in micrometres in the file");
  }
}

void set_sizes(const Header& h, VolumeInfo& info, const std::string& name) {
  const std::int64_t rank = h.dim[0];
  if (rank < 1 || rank > 7) {
    throw Error("cannot read " + name, "its header claims " + std::to_string(rank) + " dimensions", export_again);
  }
  double extra[2] = {1, 1};  // frames; components
  for (int a = 1; a <= rank; ++a) {
    const std::int64_t size = h.dim[a];
    if (size < 1 || size > std::numeric_limits<int>::max()) {
      throw Error("cannot read " + name,
                  "its header claims " + std::to_string(size) + " voxels along axis " + std::to_string(a),
                  export_again);
    }
    if (a > 3) extra[a == 5] *= static_cast<double>(size);
  }
  for (int a = 0; a < 3; ++a) info.geometry.size[a] = a < rank ? static_cast<int>(h.dim[a + 1]) : 1;
  info.frames = static_cast<int>(std::min(extra[0], 1e9));
  info.components = static_cast<int>(std::min(extra[1], 1e9));
}

void swap_bytes(unsigned char* data, std::size_t count, int size) {
  for (std::size_t i = 0; i < count; ++i, data += size) std::reverse(data, data + size);
}

/// f with the type in which the file stores its voxels.
template <class F>
void visit_stored(const Stored& stored, F&& f) {
  if (stored.wide && stored.type == VoxelType::Int32) return f(std::type_identity<std::int64_t>{});
  if (stored.wide) return f(std::type_identity<std::uint64_t>{});
  visit_voxel_type(stored.type, f);
}

struct Voxels {
  fs::path path;  ///< of the file that holds them
  std::size_t offset;
  Stored stored;
  bool swapped, rescaled;
  double slope, intercept;
  VolumeInfo info;
};

Volume read_voxels(const Voxels& v) {
  GzReader reader(v.path);
  Volume volume(v.info.geometry, v.info.type);
  const std::size_t count = v.info.geometry.voxel_count();
  const double wanted = double(v.offset) + double(count) * v.stored.bytes;
  const auto throw_damaged = [&] {
    throw Error("cannot read " + quoted(v.path), "its packed data are damaged (checksum)", export_again);
  };
  const auto require = [&](std::size_t got, std::size_t asked, std::size_t before) {
    // A read that meets bad data gives nothing of what it had unpacked before: damage is asked for first.
    if (got != asked && reader.damaged()) throw_damaged();
    if (got != asked) throw_truncated(v.path, wanted, double(v.offset + before + got));
  };
  if (!reader.skip(v.offset)) throw_truncated(v.path, wanted, double(v.offset));
  if (!v.rescaled && !v.stored.wide) {
    auto* to = static_cast<unsigned char*>(volume.data());
    require(reader.read(to, volume.bytes()), volume.bytes(), 0);
    if (v.swapped) swap_bytes(to, count, v.stored.bytes);
  } else {
    constexpr std::size_t block_size = 1 << 18;
    std::vector<unsigned char> block(block_size * v.stored.bytes);
    for (std::size_t first = 0; first < count; first += block_size) {
      const std::size_t n = std::min(block_size, count - first), bytes = n * v.stored.bytes;
      require(reader.read(block.data(), bytes), bytes, first * v.stored.bytes);
      if (v.swapped) swap_bytes(block.data(), n, v.stored.bytes);
      visit_stored(v.stored, [&]<class From>(std::type_identity<From>) {
        const auto* from = reinterpret_cast<const From*>(block.data());
        visit_voxel_type(v.info.type, [&]<class To>(std::type_identity<To>) {
          To* to = volume.voxels<To>().data() + first;
          if constexpr (std::is_floating_point_v<To>) {
            for (std::size_t i = 0; i < n; ++i) to[i] = static_cast<To>(double(from[i]) * v.slope + v.intercept);
          } else if constexpr (sizeof(From) == 8 && sizeof(To) == 4 && std::is_integral_v<From>) {
            narrow(from, n, to, quoted(v.path));
          }
        });
      });
    }
  }
  if (reader.damaged_at_end()) throw_damaged();
  return volume;
}

/// name.hdr, name.img and their .gz: the header's or the data's file.
fs::path partner(const fs::path& path, const char* kind) {
  fs::path stem = path;
  if (extension_of(path).ends_with(".gz")) stem.replace_extension();
  const bool upper = stem.extension() == ".HDR" || stem.extension() == ".IMG";
  stem.replace_extension(upper ? (std::string(kind) == ".hdr" ? ".HDR" : ".IMG") : kind);
  std::error_code error;
  const fs::path packed = stem.string() + ".gz";
  return !fs::exists(stem, error) && fs::exists(packed, error) ? packed : stem;
}

}  // namespace

bool looks_like_nifti(const fs::path& path) {
  GzReader reader(path);
  return read_header(reader).version > 0;
}

VolumeSource open_nifti(const fs::path& path) {
  const std::string extension = extension_of(path), name = quoted(path);
  const bool pair = extension.starts_with(".hdr") || extension.starts_with(".img");
  const fs::path header_path = pair ? partner(path, ".hdr") : path;
  std::error_code error;
  if (pair && !fs::exists(header_path, error) && fs::exists(path, error)) {
    throw Error("cannot read " + name, "its header " + quoted(header_path) + " is missing",
                "put both files in one folder");
  }
  GzReader reader(header_path);
  const Header h = read_header(reader);
  if (h.version < 0 || (h.version == 0 && !pair)) {
    std::array<unsigned char, 540> rest;
    if (h.version < 0 && reader.packed() && reader.read(rest.data(), 1) == 0 && reader.damaged_at_end()) {
      throw Error("cannot read " + name, "its packed data end or are damaged within the header", export_again);
    }
    throw Error("cannot read " + name, "it does not begin with a NIfTI header",
                "give it the extension of its real format, or export it again as NIfTI");
  }
  Voxels v;
  v.path = h.single_file || !pair ? header_path : partner(path, ".img");
  if (v.path != header_path && !fs::exists(v.path, error)) {
    throw Error("cannot read " + name, "only the header is there, " + quoted(v.path) + " with the voxels is missing",
                "put both files in one folder");
  }
  v.info.format = h.version == 0 ? "Analyze 7.5" : h.version == 1 ? "NIfTI-1" : "NIfTI-2";
  v.info.file_count = v.path == header_path ? 1 : 2;
  set_sizes(h, v.info, name);
  v.stored = stored_type(h.datatype, name);
  set_geometry(h, v.info);
  v.info.geometry.validate("cannot read " + name);
  warn_if_sheared(v.info);

  v.swapped = h.swapped && v.stored.bytes > 1;
  v.slope = h.slope;
  v.intercept = std::isfinite(h.intercept) ? h.intercept : 0;
  // As ITK: slope 0 means none, integers become float.
  v.rescaled = std::isfinite(v.slope) && std::abs(v.slope) > std::numeric_limits<double>::epsilon() &&
               (v.slope != 1 || v.intercept != 0);
  const bool is_float = v.stored.type == VoxelType::Float32 || v.stored.type == VoxelType::Float64;
  v.info.type = v.rescaled && !is_float ? VoxelType::Float32 : v.stored.type;
  if (v.stored.wide && !v.rescaled) v.info.warnings.push_back("64-bit integers are kept in 32 bits");
  if (!std::isfinite(h.vox_offset) || h.vox_offset < 0 || h.vox_offset > 1e15) {
    throw Error("cannot read " + name, "its header gives no sensible start of the voxels", export_again);
  }
  const double smallest = v.path == header_path ? (h.version == 2 ? 544 : 352) : 0;
  v.offset = static_cast<std::size_t>(std::max(h.vox_offset, smallest));

  // Said here already, so that a file cut short costs no memory: the whole of a plain file is known by its size.
  const double frames = double(v.info.frames) * v.info.components;
  const double wanted = double(v.offset) + double(v.info.geometry.voxel_count()) * v.stored.bytes * frames;
  const double most = v.path == header_path ? reader.most_bytes() : GzReader(v.path).most_bytes();
  if (wanted > most) throw_truncated(v.path, wanted, most);
  VolumeSource source;
  source.info = v.info;
  source.read = [v = std::move(v)] { return read_voxels(v); };
  return source;
}

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

  Eigen::Matrix3d rotation = lps_from_ras.asDiagonal() * g.direction;
  const Eigen::Matrix3d linear = rotation * g.spacing_mm.asDiagonal();
  const Eigen::Vector3d origin = lps_from_ras.cwiseProduct(g.origin_mm);
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
      const unsigned step = static_cast<unsigned>(std::min<std::size_t>(size, 1u << 30));
      if (gzwrite(file.get(), from, step) != static_cast<int>(step)) throw std::runtime_error("the write failed");
      from += step;
      size -= step;
    }
  };
  write(bytes.data(), bytes.size());
  write(volume.data(), volume.bytes());
  if (gzclose(file.release()) != Z_OK) throw std::runtime_error("the write failed");
}

}  // namespace simplexseg
