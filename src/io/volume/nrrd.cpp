// SPDX-License-Identifier: Apache-2.0
#include "io/volume/nrrd.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
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
#include "io/volume/nrrd_header.h"
#include "io/volume/nrrd_segments.h"
#include "io/volume/nrrd_space.h"

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

constexpr const char* kNrrdTypes[] = {"signed char", "unsigned char", "short", "unsigned short",
                                      "int",         "unsigned int",  "float", "double"};  // in the order of VoxelType

StoredType type_of(const NrrdHeader& header) {
  const std::string type = lower_ascii(header.text("type"));
  const auto is = [&type](std::initializer_list<const char*> names) {
    return std::any_of(names.begin(), names.end(), [&type](const char* name) { return type == name; });
  };
  if (is({"signed char", "int8", "int8_t"})) return stored_integer(1, true);
  if (is({"uchar", "unsigned char", "uint8", "uint8_t"})) return stored_integer(1, false);
  if (is({"short", "short int", "signed short", "signed short int", "int16", "int16_t"}))
    return stored_integer(2, true);
  if (is({"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"})) return stored_integer(2, false);
  if (is({"int", "signed int", "int32", "int32_t"})) return stored_integer(4, true);
  if (is({"uint", "unsigned int", "uint32", "uint32_t"})) return stored_integer(4, false);
  if (is({"longlong", "long long", "long long int", "signed long long", "signed long long int", "int64", "int64_t"}))
    return stored_integer(8, true);
  if (is({"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"}))
    return stored_integer(8, false);
  if (type == "float") return {4, VoxelType::Float32};
  if (type == "double") return {8, VoxelType::Float64};
  header.fail("its voxel type '" + one_line(type, 60) + "' is not supported",
              "save it with integer or floating-point voxels");
}

/// Axes of the array by role: space, time, or components of a voxel.
struct Axes {
  std::vector<std::size_t> space;  ///< indices of the spatial axes, at most 3
  double frames = 1, components = 1;
  double interleaved =
      1;  ///< values along axes faster than the spatial ones; 0: an axis of more values lies between them
};

Axes axes_of(const NrrdHeader& header, const std::vector<std::vector<double>>& directions) {
  const auto& sizes = header.sizes();
  const std::vector<std::string> kinds = header.words("kinds", sizes.size());
  Axes axes;
  bool after_space = false;
  for (std::size_t a = 0; a < sizes.size(); ++a) {
    const std::string kind = kinds.empty() ? "" : lower_ascii(kinds[a]);
    const bool temporal = kind == "time" || kind == "list";
    const bool spatial = kind.empty() || kind == "domain" || kind == "space" || kind == "???" || kind == "none";
    const auto size = static_cast<double>(sizes[a]);
    if (directions.empty() ? spatial : !directions[a].empty()) {
      if (after_space) axes.interleaved = 0;
      axes.space.push_back(a);
    } else {
      (temporal || spatial ? axes.frames : axes.components) *= size;
      if (axes.space.empty()) axes.interleaved *= size;
      after_space = after_space || (!axes.space.empty() && size > 1);
    }
  }
  for (; axes.space.size() > 3; axes.space.pop_back()) axes.frames *= static_cast<double>(sizes[axes.space.back()]);
  if (axes.space.empty()) header.fail("it has no spatial axis");
  return axes;
}

double millimetres(const NrrdHeader& header, const std::string& unit) {
  const auto mm = millimetres_of(unit);
  if (!mm) {
    header.fail("its unit '" + one_line(unit, 40) + "' is not a known unit of length",
                "write the lengths in its header in mm");
  }
  return *mm;
}

void warn_about_unit(VolumeInfo& info, const std::string& unit, double mm) {
  const std::string warning = "lengths are in " + one_line(unit, 40) + " in the file";
  if (mm != 1 && std::find(info.warnings.begin(), info.warnings.end(), warning) == info.warnings.end())
    info.warnings.push_back(warning);
}

/// Computes the columns after the first `given` ones, orthogonal to all others.
void complete_axes(std::array<Eigen::Vector3d, 3>& columns, std::size_t given) {
  if (given == 1) columns[1] = columns[0].unitOrthogonal();
  if (given < 3) columns[2] = columns[0].cross(columns[1]).normalized();
}

/// Sets origin, spacing and direction from a header with a space or with space directions.
void set_geometry_in_space(const NrrdHeader& header, const Axes& axes,
                           const std::vector<std::vector<double>>& directions, VolumeInfo& info) {
  NrrdSpace space;
  const std::string name = header.text("space");
  if (header.has("space")) {
    const auto known = nrrd_space_of(name);
    if (!known) header.fail("its space '" + one_line(name, 60) + "' is unknown");
    space = *known;
  } else {
    space.dimension = static_cast<int>(header.integer("space dimension", 3, 2, 4));
    space.anatomical = false;
  }
  if (!space.anatomical) {
    info.warnings.push_back(
        (header.has("space") ? "its space is '" + one_line(name, 60) + "'" : "its space has no name") +
        std::string(": the patient's left and right are unknown"));
  }
  Eigen::Vector3d mm(1, 1, 1);
  const auto units = header.words("space units", static_cast<std::size_t>(space.dimension));
  for (int a = 0; a < std::min(space.dimension, 3) && !units.empty(); ++a) {
    mm[a] = millimetres(header, units[static_cast<std::size_t>(a)]);
    warn_about_unit(info, units[static_cast<std::size_t>(a)], mm[a]);
  }
  const auto in_lps = [&](const std::vector<double>& vector) {
    Eigen::Vector3d v(0, 0, 0);
    for (int a = 0; a < std::min(space.dimension, 3); ++a) v[a] = vector[static_cast<std::size_t>(a)] * mm[a];
    return Eigen::Vector3d(space.lps_from_space * v);
  };
  std::array<Eigen::Vector3d, 3> columns;
  const std::vector<double> spacings = directions.empty() ? header.numbers("spacings") : std::vector<double>();
  for (std::size_t a = 0; a < axes.space.size(); ++a) {
    std::vector<double> step(4, 0.0);
    step[a] = spacings.empty() ? 1 : spacings[axes.space[a]];
    columns[a] = in_lps(directions.empty() ? step : directions[axes.space[a]]);
  }
  if (directions.empty() && spacings.empty()) info.warnings.push_back("the header has no voxel size: 1 mm is assumed");
  complete_axes(columns, axes.space.size());
  for (std::size_t a = 0; a < 3; ++a) {
    const double length = columns[a].stableNorm();
    info.geometry.spacing_mm[static_cast<int>(a)] = length;
    info.geometry.direction.col(static_cast<int>(a)) = columns[a] / length;
  }
  const auto origin = header.vectors("space origin", 1, space.dimension);
  if (!origin.empty() && !origin[0].empty()) info.geometry.origin_mm = in_lps(origin[0]);
}

/// Sets origin and spacing from the fields of each axis, for a header without a space.
void set_geometry_by_axes(const NrrdHeader& header, const Axes& axes, VolumeInfo& info) {
  const auto spacings = header.numbers("spacings"), axis_minima = header.numbers("axis mins");
  const auto axis_maxima = header.numbers("axis maxs");
  bool all_known = true;
  const auto units = header.words("units", header.sizes().size());
  const auto centers = header.words("centers", header.sizes().size());
  for (std::size_t a = 0; a < axes.space.size(); ++a) {
    const std::size_t axis = axes.space[a];
    const double mm = units.empty() ? 1 : millimetres(header, units[axis]);
    if (!units.empty()) warn_about_unit(info, units[axis], mm);
    const bool at_cells = centers.empty() || lower_ascii(centers[axis]) != "node";
    double spacing = spacings.empty() ? std::nan("") : spacings[axis];
    const auto steps = static_cast<double>(header.sizes()[axis]) - (at_cells ? 0 : 1);
    if (std::isnan(spacing) && !axis_minima.empty() && !axis_maxima.empty() && steps > 0)
      spacing = (axis_maxima[axis] - axis_minima[axis]) / steps;
    all_known = all_known && !std::isnan(spacing);
    spacing = std::isnan(spacing) ? 1 : spacing * mm;
    info.geometry.set_step(static_cast<int>(a), spacing);
    if (!axis_minima.empty() && !std::isnan(axis_minima[axis]))
      info.geometry.origin_mm[static_cast<int>(a)] = axis_minima[axis] * mm + (at_cells ? spacing / 2 : 0);
  }
  if (!all_known) info.warnings.push_back("the header has no voxel size: 1 mm is assumed");
  info.warnings.push_back("the header has no orientation: the patient's left and right are unknown");
}

std::string vector_text(std::span<const double> vector) {
  std::string text;
  for (const double x : vector) text.append(text.empty() ? "(" : ",").append(digits_of(x));
  return text + ')';
}

/// Name of a space without its time axis.
std::string spatial_name(const std::string& name) {
  return name.substr(0, name.size() - (lower_ascii(name).ends_with("-time") ? 5 : 1));
}

/// Header lines that place the three spatial axes; nullopt for fewer axes, and for directions through time.
std::optional<std::string> nrrd_placement(const NrrdHeader& header, const Axes& axes,
                                          const std::vector<std::vector<double>>& directions, int dimension) {
  if (axes.space.size() < 3 || dimension < 3 || dimension > 4) return std::nullopt;
  std::string lines;
  const auto add = [&lines](const std::string& field, const std::string& value) {
    lines.append(field).append(": ").append(value).append("\n");
  };
  const auto add_words = [&](const char* field, bool in_quotes = false) {
    const auto words = header.words(field, header.sizes().size());
    if (words.empty()) return;
    std::string text;
    for (const std::size_t axis : axes.space)
      text.append(text.empty() ? "" : " ").append(in_quotes ? '"' + words[axis] + '"' : words[axis]);
    add(field, text);
  };
  if (!header.has("space") && directions.empty()) {
    for (const char* field : {"spacings", "axis mins", "axis maxs", "centers"}) add_words(field);
    add_words("units", true);
    return lines;
  }
  if (header.has("space"))
    add("space", dimension == 4 ? spatial_name(header.text("space")) : header.text("space"));
  else
    add("space dimension", "3");
  if (const auto units = header.words("space units", static_cast<std::size_t>(dimension)); !units.empty())
    add("space units", '"' + units[0] + "\" \"" + units[1] + "\" \"" + units[2] + '"');
  if (directions.empty()) add_words("spacings");
  if (!directions.empty()) {
    std::string text;
    for (const std::size_t axis : axes.space) {
      const std::vector<double>& direction = directions[axis];
      if (dimension == 4 && direction[3] != 0) return std::nullopt;
      text.append(text.empty() ? "" : " ").append(vector_text(std::span(direction).first(3)));
    }
    add("space directions", text);
  }
  if (const auto origin = header.vectors("space origin", 1, dimension); !origin.empty() && !origin[0].empty())
    add("space origin", vector_text(std::span(origin[0]).first(3)));
  return lines;
}

/// Header lines that place a grid in LPS.
std::string nrrd_placement(const VolumeGeometry& g) {
  const auto vector = [](const Eigen::Vector3d& v) { return vector_text(std::span(v.data(), 3)); };
  std::string lines = "space: left-posterior-superior\nspace units: \"mm\" \"mm\" \"mm\"\nspace directions:";
  for (int a = 0; a < 3; ++a) lines.append(1, ' ').append(vector(g.direction.col(a) * g.spacing_mm[a]));
  return lines + "\nspace origin: " + vector(g.origin_mm) + "\n";
}

/// Data files of a detached header: a single file, or one for each slice.
std::vector<fs::path> files_of(const NrrdHeader& header, const fs::path& path) {
  const std::string text = header.text("data file");
  std::vector<std::string> words = words_of(text);
  const auto& sizes = header.sizes();
  const auto dimension_in = [&](const std::string& word) {
    const auto dimension = number_of<std::int64_t>(word);
    if (!dimension || *dimension < 1 || *dimension > static_cast<std::int64_t>(sizes.size()))
      header.fail("its field 'data file' is '" + one_line(text, 100) + "', which has an invalid dimension");
    return *dimension;
  };
  const auto default_dimension = std::max<std::int64_t>(1, static_cast<std::int64_t>(sizes.size()) - 1);
  if (lower_ascii(text).starts_with("list")) {
    const std::int64_t dimension = words.size() > 1 ? dimension_in(words[1]) : default_dimension;
    return listed_files(path, header.listed_files(), count_of_slices(sizes, dimension));
  }
  if (text.find('%') == std::string::npos || words.size() < 4) return {path.parent_path() / text};
  const auto number = [&](std::size_t w) {
    const auto value = number_of<std::int32_t>(words[w]);
    if (!value) header.fail("its field 'data file' is '" + one_line(text, 100) + "', not a pattern and three numbers");
    return static_cast<long>(*value);
  };
  const long first = number(1), last = number(2), step = number(3);
  const double count = count_of_slices(sizes, words.size() > 4 ? dimension_in(words[4]) : default_dimension);
  if (step == 0 || std::floor(static_cast<double>(last - first) / static_cast<double>(step)) + 1 != count ||
      count > 1e6)
    header.fail("its field 'data file' does not name one file for each of the " + digits_of(count) + " slices");
  return numbered_files(path, words[0], first, step, static_cast<int>(count));
}

/// Number of bytes in the first `count` lines of a file.
std::uint64_t bytes_of_lines(const fs::path& path, std::int64_t count) {
  HeaderLines lines(path);
  for (std::int64_t line = 0; line < count && lines.next(); ++line) {
  }
  return lines.bytes_read();
}

void read_encoding(const NrrdHeader& header, const fs::path& path, StoredVoxels& voxels) {
  const std::string encoding = lower_ascii(header.text("encoding"));
  if (encoding == "gzip" || encoding == "gz")
    voxels.compression = Compression::Deflate;
  else if (encoding == "bzip2" || encoding == "bz2")
    voxels.compression = Compression::Bzip2;
  else if (encoding == "txt" || encoding == "text" || encoding == "ascii")
    voxels.encoding = VoxelEncoding::Text;
  else if (encoding == "hex")
    voxels.encoding = VoxelEncoding::Hexadecimal;
  else if (encoding != "raw")
    header.fail("its encoding '" + one_line(encoding, 60) + "' is not supported",
                "save it with the encoding raw, gzip or bzip2");
  const std::string endian = lower_ascii(header.text("endian"));
  if (header.has("endian") && endian != "little" && endian != "big")
    header.fail("its byte order '" + one_line(endian, 60) + "' is neither little nor big");
  voxels.swapped = endian == "big";

  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max() / 4;
  const std::int64_t bytes = header.integer("byte skip", 0, -1, kMax), lines = header.integer("line skip", 0, 0, kMax);
  if (header.has("data file")) {
    voxels.files = files_of(header, path);
    std::error_code error;
    if (lines > 0 && fs::exists(voxels.files[0], error)) voxels.offset = bytes_of_lines(voxels.files[0], lines);
  } else {
    voxels.files = {path};
    voxels.offset = header.bytes();
    if (lines > 0) header.fail("its field 'line skip' is allowed in detached headers only", "delete that field");
  }
  voxels.at_end = bytes < 0;
  if (voxels.at_end && (voxels.compression != Compression::None || voxels.encoding != VoxelEncoding::Binary))
    header.fail("its field 'byte skip' is -1, which is allowed for raw voxels only");
  if (bytes > 0) voxels.skipped = static_cast<std::uint64_t>(bytes);
}

}  // namespace

VolumeSource open_nrrd(const fs::path& path, int volume) {
  const NrrdHeader header(path);
  VolumeInfo info;
  info.format = "NRRD";
  int dimension = static_cast<int>(header.integer("space dimension", 3, 1, 16));
  if (header.has("space")) {
    const auto space = nrrd_space_of(header.text("space"));
    dimension = space ? space->dimension : 3;
  }
  const auto directions = header.vectors("space directions", header.sizes().size(), dimension);
  const Axes axes = axes_of(header, directions);
  info.frames = static_cast<int>(std::min(axes.frames, 1e9));
  info.components = static_cast<int>(std::min(axes.components, 1e9));
  info.segments = segments_of(header);
  for (std::size_t a = 0; a < 3; ++a)
    info.geometry.size[a] = a < axes.space.size() ? static_cast<int>(header.sizes()[axes.space[a]]) : 1;
  if (header.has("space") || !directions.empty())
    set_geometry_in_space(header, axes, directions, info);
  else
    set_geometry_by_axes(header, axes, info);
  if (const auto lines = nrrd_placement(header, axes, directions, dimension))
    keep_header(info.geometry, NrrdFrame{*lines});
  StoredVoxels voxels;
  voxels.type = type_of(header);
  voxels.interleaved = static_cast<int>(std::min(axes.interleaved, 1e9));
  read_encoding(header, path, voxels);
  info.file_count = static_cast<int>(voxels.files.size()) + (header.has("data file") ? 1 : 0);
  if (!info.segments.empty() && (info.components > 1 || info.frames > 1))
    return open_layers(info, voxels, header, path);
  return open_stored(std::move(info), std::move(voxels), path, volume);
}

void write_nrrd(AtomicFile& file, const Volume& volume, const std::string& keys) {
  const VolumeGeometry& g = volume.geometry();
  const NrrdFrame* const stored = stored_frame<NrrdFrame>(g);
  std::string text = "NRRD0004\n# https://teem.sourceforge.net/nrrd/format.html\n";
  text += std::string("type: ") + kNrrdTypes[static_cast<int>(volume.type())] + "\ndimension: 3\nsizes:";
  for (const int size : g.size) text.append(1, ' ').append(std::to_string(size));
  text += "\n" + (stored ? stored->lines : nrrd_placement(g));
  text += "kinds: domain domain domain\nendian: little\nencoding: gzip\n" + keys + "\n";
  write_bytes(file, text);
  CompressingWriter compressed(file, CompressingWriter::Frame::Gzip);
  compressed.write(volume.data(), volume.bytes());
  compressed.finish();
}

}  // namespace simplexseg
