// SPDX-License-Identifier: Apache-2.0
#include "io/volume/meta_image.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "core/number_text.h"
#include "io/platform/atomic_file.h"
#include "io/platform/compressing_writer.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"
#include "io/source/stored_header.h"
#include "io/source/stored_voxels.h"
#include "io/volume/nrrd_space.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr std::int64_t kMaxAxes = 10;
constexpr const char* kTypes[] = {"MET_CHAR", "MET_UCHAR", "MET_SHORT", "MET_USHORT",
                                  "MET_INT",  "MET_UINT",  "MET_FLOAT", "MET_DOUBLE"};  // in the order of VoxelType

/// Header of a MetaImage file: values by key. The key ElementDataFile ends the header.
class MetaHeader {
 public:
  explicit MetaHeader(const fs::path& path) : path_(path) {
    HeaderLines lines(path);
    std::optional<std::string> line;
    while (!has("ElementDataFile") && (line = lines.next())) {
      const std::size_t sign = line->find_first_of("=:");
      const std::string key = trimmed(line->substr(0, sign));
      if (sign == std::string::npos || key.empty()) {
        if (trimmed(*line).empty()) continue;
        break;
      }
      values_.emplace(key, trimmed(line->substr(sign + 1)));
    }
    const std::string kind = text("ObjectType");
    if (values_.empty() || !has("NDims") || (!kind.empty() && lower_ascii(kind) != "image"))
      fail("it is not a readable MetaImage file", "rename it with the extension of its format");
    if (!has("ElementDataFile")) fail("its header has no key ElementDataFile", "copy or export it again");
    bytes_ = lines.bytes_read();
    if (lower_ascii(text("ElementDataFile")).starts_with("list")) {
      while ((line = lines.next())) {
        if (!trimmed(*line).empty()) listed_.push_back(trimmed(*line));
      }
    }
    axes_ = static_cast<std::size_t>(integer("NDims", 0, 1, kMaxAxes));
  }

  bool has(const std::string& key) const { return values_.contains(key); }
  std::string text(const std::string& key) const {
    const auto found = values_.find(key);
    return found == values_.end() ? "" : found->second;
  }
  bool is_true(const std::string& key) const {
    const std::string value = text(key);
    return !value.empty() && std::string("TtYy1").find(value[0]) != std::string::npos;
  }
  /// Whole number in a range; `otherwise` if the key is missing. Throws Error for any other text.
  std::int64_t integer(const std::string& key, std::int64_t otherwise, std::int64_t minimum,
                       std::int64_t maximum) const {
    if (!has(key)) return otherwise;
    const auto value = number_of<std::int64_t>(text(key));
    if (!value || *value < minimum || *value > maximum)
      fail(key + " is '" + one_line(text(key), 60) + "', not a whole number from " + std::to_string(minimum) + " to " +
           std::to_string(maximum));
    return *value;
  }
  /// Numbers of the first of `keys` that is present; empty if none is. Throws Error unless there are `count` numbers.
  std::vector<double> numbers(std::initializer_list<const char*> keys, std::size_t count) const {
    for (const char* key : keys) {
      if (!has(key)) continue;
      std::vector<double> values;
      for (const std::string& word : words_of(text(key))) {
        const auto value = number_of<double>(lower_ascii(word));
        if (!value) fail(std::string(key) + " has '" + one_line(word, 60) + "', which is not a number");
        values.push_back(*value);
      }
      if (values.size() != count)
        fail(std::string(key) + " has " + std::to_string(values.size()) + " numbers instead of " +
             std::to_string(count));
      return values;
    }
    return {};
  }
  std::size_t axes() const { return axes_; }
  std::uint64_t bytes() const { return bytes_; }
  const std::vector<std::string>& listed_files() const { return listed_; }

  [[noreturn]] void fail(const std::string& why, const std::string& what_to_do = "correct its header") const {
    throw Error("cannot read " + quoted(path_), why, what_to_do);
  }

 private:
  fs::path path_;
  std::map<std::string, std::string> values_;
  std::vector<std::string> listed_;
  std::size_t axes_ = 0;
  std::uint64_t bytes_ = 0;
};

StoredType type_of(const MetaHeader& header) {
  std::string type = header.text("ElementType");
  if (type.ends_with("_ARRAY")) type.erase(type.size() - 6);
  for (int t = 0; t < 8; ++t) {
    const auto voxel = static_cast<VoxelType>(t);
    if (type == kTypes[t]) return {static_cast<int>(bytes_per_voxel(voxel)), voxel};
  }
  if (type == "MET_LONG" || type == "MET_ULONG") return stored_integer(4, type == "MET_LONG");
  if (type == "MET_LONG_LONG" || type == "MET_ULONG_LONG") return stored_integer(8, type == "MET_LONG_LONG");
  header.fail("its voxel type '" + one_line(type, 60) + "' is not supported",
              "save it with integer or floating-point voxels");
}

/// Numbers of a header line " = a b c".
std::string numbers_line(const char* key, std::span<const double> numbers) {
  std::string line = std::string(key) + " =";
  for (const double x : numbers) line.append(1, ' ').append(digits_of(x));
  return line + '\n';
}

/// Header lines that place the first three axes. Empty vectors: the header has no such numbers.
std::string meta_image_placement(const MetaHeader& header, const std::vector<double>& spacing,
                                 const std::vector<double>& origin, const std::vector<double>& matrix) {
  std::string lines;
  if (!matrix.empty()) {
    std::vector<double> columns;
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t r = 0; r < 3; ++r) columns.push_back(matrix[a * header.axes() + r]);
    }
    lines += numbers_line("TransformMatrix", columns);
  }
  if (!origin.empty()) lines += numbers_line("Offset", std::span(origin).first(3));
  if (const auto centre = words_of(header.text("CenterOfRotation")); centre.size() == header.axes())
    lines += "CenterOfRotation = " + centre[0] + " " + centre[1] + " " + centre[2] + "\n";
  if (const std::string code = header.text("AnatomicalOrientation"); code.size() >= 3)
    lines += "AnatomicalOrientation = " + code.substr(0, 3) + "\n";
  if (header.has("DistanceUnits")) lines += "DistanceUnits = " + header.text("DistanceUnits") + "\n";
  if (!spacing.empty()) lines += numbers_line("ElementSpacing", std::span(spacing).first(3));
  return lines;
}

/// Header lines that place a grid.
std::string meta_image_placement(const VolumeGeometry& g) {
  return numbers_line("TransformMatrix", std::span(g.direction.data(), 9)) +
         numbers_line("Offset", std::span(g.origin_mm.data(), 3)) + "CenterOfRotation = 0 0 0\n" +
         numbers_line("ElementSpacing", std::span(g.spacing_mm.data(), 3));
}

void read_geometry(const MetaHeader& header, VolumeInfo& info) {
  const std::size_t axes = header.axes();
  double frames = 1;
  const auto sizes = words_of(header.text("DimSize"));
  if (sizes.size() != axes)
    header.fail("DimSize has " + std::to_string(sizes.size()) + " numbers for " + std::to_string(axes) + " axes");
  info.geometry.size = {1, 1, 1};
  for (std::size_t a = 0; a < axes; ++a) {
    const auto size = number_of<std::int64_t>(sizes[a]);
    if (!size || *size < 1 || *size > std::numeric_limits<int>::max())
      header.fail("DimSize claims '" + one_line(sizes[a], 60) + "' voxels along an axis");
    if (a < 3)
      info.geometry.size[a] = static_cast<int>(*size);
    else
      frames *= static_cast<double>(*size);
  }
  info.frames = static_cast<int>(std::min(frames, 1e9));
  info.components = static_cast<int>(header.integer("ElementNumberOfChannels", 1, 1, 1 << 30));

  const auto spacing = header.numbers({"ElementSpacing", "ElementSize"}, axes);
  const auto origin = header.numbers({"Offset", "Position", "Origin"}, axes);
  const auto matrix = header.numbers({"TransformMatrix", "Orientation", "Rotation"}, axes * axes);
  for (std::size_t a = 0; a < std::min<std::size_t>(axes, 3); ++a) {
    const int column = static_cast<int>(a);
    if (!origin.empty()) info.geometry.origin_mm[column] = origin[a];
    for (std::size_t r = 0; r < std::min<std::size_t>(axes, 3) && !matrix.empty(); ++r)
      info.geometry.direction(static_cast<int>(r), column) = matrix[a * axes + r];
    if (!spacing.empty()) info.geometry.set_step(column, spacing[a]);
  }
  const std::string unit = header.text("DistanceUnits");
  const std::optional<double> mm = unit == "?" ? 1 : millimetres_of(unit);
  if (!mm) header.fail("DistanceUnits is '" + one_line(unit, 40) + "', which is not a known unit of length");
  info.geometry.spacing_mm *= *mm;
  info.geometry.origin_mm *= *mm;
  if (*mm != 1) info.warnings.push_back("lengths are in " + unit + " in the file; other programs may read them as mm");
  if (axes >= 3) keep_header(info.geometry, MetaImageFrame{meta_image_placement(header, spacing, origin, matrix)});
  if (spacing.empty()) info.warnings.push_back("the header has no voxel size: 1 mm is assumed");
}

/// Reads the function from stored values to intensities.
void read_rescaling(const MetaHeader& header, StoredVoxels& voxels, VolumeInfo& info) {
  const auto slope = header.numbers({"ElementToIntensityFunctionSlope"}, 1);
  const auto offset = header.numbers({"ElementToIntensityFunctionOffset"}, 1);
  if (!slope.empty() && slope[0] == 0) header.fail("ElementToIntensityFunctionSlope is 0: all values would be equal");
  voxels.slope = slope.empty() ? 1 : slope[0];
  voxels.intercept = offset.empty() ? 0 : offset[0];
  voxels.rescaled = voxels.slope != 1 || voxels.intercept != 0;
  if (voxels.rescaled)
    info.warnings.push_back("values are rescaled by ElementToIntensityFunction; other programs may not do this");
}

std::vector<fs::path> files_of(const MetaHeader& header, const fs::path& path) {
  const std::string text = header.text("ElementDataFile");
  const std::vector<std::string> words = words_of(text);
  std::vector<std::int64_t> sizes;
  for (const std::string& word : words_of(header.text("DimSize")))
    sizes.push_back(number_of<std::int64_t>(word).value_or(0));
  const auto whole = [&](std::size_t w, long otherwise, long minimum, long maximum) {
    if (words.size() <= w) return otherwise;
    const auto value = number_of<std::int32_t>(words[w]);
    if (!value || *value < minimum || *value > maximum)
      header.fail("ElementDataFile is '" + one_line(text, 100) + "', which has invalid numbers");
    return static_cast<long>(*value);
  };
  constexpr long kMax = std::numeric_limits<std::int32_t>::max();
  const long axes = static_cast<long>(sizes.size()), slices = std::max(1L, axes - 1);
  if (lower_ascii(text).starts_with("list")) {
    return listed_files(path, header.listed_files(), count_of_slices(sizes, whole(1, slices, 1, axes)));
  }
  if (text.find('%') == std::string::npos) return {path.parent_path() / text};
  const double count = count_of_slices(sizes, slices);
  const long first = whole(1, 1, 0, kMax), step = whole(3, 1, 1, kMax);
  const double last = static_cast<double>(first) + (count - 1) * static_cast<double>(step);
  if (count > 1e6 || last > static_cast<double>(whole(2, kMax, 0, kMax)))
    header.fail("ElementDataFile does not name one file for each of the " + digits_of(count) + " slices");
  return numbered_files(path, words[0], first, step, static_cast<int>(count));
}

}  // namespace

VolumeSource open_meta_image(const fs::path& path, int volume) {
  const MetaHeader header(path);
  VolumeInfo info;
  info.format = "MetaImage";
  read_geometry(header, info);
  StoredVoxels voxels;
  voxels.type = type_of(header);
  read_rescaling(header, voxels, info);
  const bool local = lower_ascii(header.text("ElementDataFile")) == "local";
  voxels.files = local ? std::vector<fs::path>{path} : files_of(header, path);
  if (local) voxels.offset = header.bytes();
  if (header.is_true("CompressedData")) voxels.compression = Compression::Deflate;
  if (header.has("BinaryData") && !header.is_true("BinaryData")) voxels.encoding = VoxelEncoding::Text;
  voxels.swapped = header.is_true("BinaryDataByteOrderMSB") || header.is_true("ElementByteOrderMSB");
  const std::int64_t skipped = header.integer("HeaderSize", 0, -1, std::numeric_limits<std::int64_t>::max() / 4);
  voxels.at_end = skipped < 0 && voxels.compression == Compression::None && voxels.encoding == VoxelEncoding::Binary;
  if (skipped > 0) voxels.offset = static_cast<std::uint64_t>(skipped);
  info.file_count = static_cast<int>(voxels.files.size()) + (local ? 0 : 1);
  return open_stored(std::move(info), std::move(voxels), path, volume);
}

void write_meta_image(AtomicFile& file, const Volume& volume) {
  const VolumeGeometry& g = volume.geometry();
  std::string text =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = True\n"
      "CompressedDataSize = ";
  const std::size_t place = text.size();
  const MetaImageFrame* const stored = stored_frame<MetaImageFrame>(g);
  text.append(20, ' ').append("\n");  // blanks that the compressed size replaces at the end
  text += (stored ? stored->lines : meta_image_placement(g)) + "DimSize =";
  for (const int size : g.size) text.append(1, ' ').append(std::to_string(size));
  text += std::string("\nElementType = ") + kTypes[static_cast<int>(volume.type())] + "\nElementDataFile = LOCAL\n";
  write_bytes(file, text);
  CompressingWriter compressed(file, CompressingWriter::Frame::Zlib);
  compressed.write(volume.data(), volume.bytes());
  const std::string size = std::to_string(compressed.finish());
  file.write_at(place, size.data(), size.size());
}

}  // namespace simplexseg
