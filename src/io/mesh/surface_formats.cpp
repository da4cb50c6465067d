// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/surface_formats.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>

#include "io/platform/files.h"
#include "io/platform/header_text.h"

namespace simplexseg {
namespace {

constexpr const char* kTruncated = "truncated: it ends within its data";

std::string in_quotes(std::string_view word) { return quoted(std::string(word.substr(0, 20))); }

/// Reads words, lines, decimal numbers and big-endian values from the bytes of a file.
class Cursor {
 public:
  Cursor(std::string_view bytes, const Fail& fail) : bytes_(bytes), fail_(fail) {}

  bool at_end() {
    skip_blanks();
    return at_ >= bytes_.size();
  }
  std::string_view word() {
    skip_blanks();
    const std::size_t begin = at_;
    while (at_ < bytes_.size() && !is_blank(bytes_[at_])) ++at_;
    return bytes_.substr(begin, at_ - begin);
  }
  std::string_view line() {
    const std::size_t end = std::min(bytes_.find('\n', at_), bytes_.size());
    const std::string_view text = bytes_.substr(at_, end - at_);
    at_ = std::min(end + 1, bytes_.size());
    return text;
  }
  template <class T>
  T number() {
    const std::string_view text = word();
    std::optional<T> value;
    if constexpr (std::is_same_v<T, float>) {  // a number too small for the type is 0, one too large is refused
      const std::optional<double> wide = number_of<double>(text);
      if (wide && !(std::fabs(*wide) > double(std::numeric_limits<float>::max()))) value = static_cast<float>(*wide);
    } else {
      value = number_of<T>(text);
    }
    if (!value) fail_(text.empty() ? kTruncated : in_quotes(text) + " is not a number");
    return *value;
  }
  template <class T>
  T big_endian() {
    if (bytes_.size() - at_ < sizeof(T)) fail_(kTruncated);
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }
  std::size_t left() const { return bytes_.size() - at_; }
  bool starts_with(std::string_view text) const { return bytes_.substr(at_).starts_with(text); }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
  void skip_blanks() {
    while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
  }

  std::string_view bytes_;
  const Fail& fail_;
  std::size_t at_ = 0;
};

void add_polygon(PolygonSurface& surface, const std::vector<long long>& corners, const Fail& fail) {
  if (corners.size() < 3) fail("a polygon has fewer than three corners");
  for (const long long v : corners) {
    if (v < 0 || v >= static_cast<long long>(surface.positions.size()))
      fail("a polygon refers to point " + std::to_string(v) + " of " + std::to_string(surface.positions.size()));
    surface.polygons.vertices.push_back(static_cast<int>(v));
  }
  surface.polygons.offsets.push_back(static_cast<int>(surface.polygons.vertices.size()));
}

/// Adds polygons. `corners`: corners of all polygons; `ends`: end of each polygon in `corners`, after an optional first
/// 0.
void add_polygons(PolygonSurface& surface, const std::vector<long long>& ends, const std::vector<long long>& corners,
                  const Fail& fail) {
  long long begin = 0;
  for (const long long end : ends) {
    if (end < begin || end > static_cast<long long>(corners.size())) fail("its polygon offsets are not ascending");
    if (end > begin) add_polygon(surface, {corners.begin() + begin, corners.begin() + end}, fail);
    begin = end;
  }
}

/// Adds the triangles of triangle strips, in which every second triangle is turned. Arguments as for add_polygons().
void add_strips(PolygonSurface& surface, const std::vector<long long>& ends, const std::vector<long long>& corners,
                const Fail& fail) {
  const auto corner = [&](long long n) { return corners[static_cast<std::size_t>(n)]; };
  long long begin = 0;
  for (const long long end : ends) {
    if (end < begin || end > static_cast<long long>(corners.size())) fail("its strip offsets are not ascending");
    for (long long n = begin; n + 2 < end; ++n) {
      const long long odd = (n - begin) % 2;
      add_polygon(surface, {corner(n + odd), corner(n + 1 - odd), corner(n + 2)}, fail);
    }
    begin = end;
  }
}

/// Converts a number of a file to another type. Returns -1, which is not a valid index, if a floating-point number is
/// not whole, too large for an exact integer, or NaN.
template <class To, class From>
To converted_to(From value) {
  if constexpr (std::is_integral_v<To> && std::is_floating_point_v<From>) {
    constexpr double kMaxExact = 9007199254740992;  // 2^53: doubles represent all integers up to here
    if (!(std::fabs(static_cast<double>(value)) <= kMaxExact) || value != std::floor(value)) return -1;
  }
  return static_cast<To>(value);
}

/// Reads one value of a VTK array. `type`: VTK name of the type in a binary array.
template <class To>
To vtk_value(Cursor& cursor, std::string_view type, bool binary, const Fail& fail) {
  if (!binary) return converted_to<To>(cursor.number<double>());
  if (type == "float") return converted_to<To>(cursor.big_endian<float>());
  if (type == "double") return converted_to<To>(cursor.big_endian<double>());
  if (type == "int") return static_cast<To>(cursor.big_endian<std::int32_t>());
  if (type == "vtktypeint64" || type == "long") return static_cast<To>(cursor.big_endian<std::int64_t>());
  fail(std::string("its data type ").append(in_quotes(type)).append(" is not supported"));
  return {};
}

/// Cells of a section of a legacy VTK file: corners of all cells, and the end of each cell in them after an optional 0.
struct VtkCells {
  std::vector<long long> ends, corners;
};

/// Reads the cells after the name of their section.
VtkCells vtk_cells(Cursor& cursor, bool binary, const Fail& fail) {
  VtkCells cells;
  const auto count = cursor.number<std::uint64_t>(), size = cursor.number<std::uint64_t>();
  cursor.line();
  if (count > cursor.left() || size > cursor.left()) fail(kTruncated);
  if (cursor.starts_with("OFFSETS")) {  // version 5
    for (std::vector<long long>* const part : {&cells.ends, &cells.corners}) {
      cursor.word();
      const std::string_view type = cursor.word();
      cursor.line();
      for (std::uint64_t n = 0; n < (part == &cells.ends ? count : size); ++n)
        part->push_back(vtk_value<long long>(cursor, type, binary, fail));
    }
    return cells;
  }
  for (std::uint64_t n = 0; n < count; ++n) {
    const auto length = vtk_value<long long>(cursor, "int", binary, fail);
    if (length < 1 || length > static_cast<long long>(size))
      fail("a polygon has " + std::to_string(length) + " corners");
    for (long long c = 0; c < length; ++c) cells.corners.push_back(vtk_value<long long>(cursor, "int", binary, fail));
    cells.ends.push_back(static_cast<long long>(cells.corners.size()));
  }
  return cells;
}

/// Value of an attribute in an XML tag; empty if it is missing.
std::string_view attribute(std::string_view tag, std::string_view name) {
  for (std::size_t at = tag.find(name); at != tag.npos; at = tag.find(name, at + 1)) {
    const std::size_t quote = at + name.size() + 1;
    if (at == 0 || tag[at - 1] != ' ' || quote >= tag.size() || tag[quote - 1] != '=' || tag[quote] != '"') continue;
    const std::size_t end = tag.find('"', quote + 1);
    if (end != tag.npos) return tag.substr(quote + 1, end - quote - 1);
  }
  return {};
}

template <class From, class To>
std::vector<To> raw_values(std::string_view block) {
  std::vector<To> values(block.size() / sizeof(From));
  for (std::size_t n = 0; n < values.size(); ++n) {
    From value;
    std::memcpy(&value, block.data() + n * sizeof value, sizeof value);
    values[n] = converted_to<To>(value);
  }
  return values;
}

/// Reads the arrays of a VTP file, piece by piece.
class VtpReader {
 public:
  VtpReader(std::string_view bytes, const Fail& fail) : bytes_(bytes), xml_(bytes), fail_(fail) {
    const std::size_t file = bytes.find("<VTKFile");
    if (file == bytes.npos) fail("it is not a VTK XML file");
    root_ = tag_at(file);
    if (attribute(root_, "type") != "PolyData") fail("it contains no polygons");
    if (!attribute(root_, "compressor").empty()) fail("its data is compressed");
    if (attribute(root_, "byte_order") == "BigEndian") fail("its data is big endian");
    const std::size_t appended = bytes.find("<AppendedData");
    if (appended == bytes.npos) return;
    xml_ = bytes.substr(0, appended);
    raw_ = attribute(tag_at(appended), "encoding") == "raw";
    data_ = bytes.find('_', appended + tag_at(appended).size());
    if (data_ == bytes.npos) fail(kTruncated);
  }

  /// Moves to the next piece; returns false after the last.
  bool next_piece() {
    begin_ = xml_.find("<Piece", end_);
    if (begin_ == xml_.npos) return false;
    const std::string_view tag = tag_at(begin_);
    end_ = tag.ends_with("/>") ? begin_ + tag.size() : std::min(xml_.find("</Piece", begin_), xml_.size());
    return true;
  }
  /// Whether the piece states 0 for an attribute such as NumberOfPolys; `otherwise` without the attribute.
  bool is_zero(std::string_view count, bool otherwise) const {
    const std::string_view value = attribute(tag_at(begin_), count);
    return value.empty() ? otherwise : value == "0";
  }
  /// Text of a string array in the field data; empty if there is none.
  std::string field_text(std::string_view name) const {
    const std::size_t begin = xml_.find("<FieldData"), end = xml_.find("</FieldData", begin);
    for (std::size_t at = xml_.find("<DataArray", begin); at < end; at = xml_.find("<DataArray", at + 1)) {
      const std::string_view tag = tag_at(at);
      if (attribute(tag, "Name") != name) continue;
      if (attribute(tag, "format") == "appended" && raw_) return std::string(block_at(attribute(tag, "offset")));
      std::string text;  // codes of the characters
      const std::size_t codes = at + tag.size();
      Cursor cursor(xml_.substr(codes, xml_.find('<', codes) - codes), fail_);
      while (!cursor.at_end()) text += static_cast<char>(cursor.number<int>());
      return text;
    }
    return {};
  }

  /// Values of the DataArray `name` in a section of the piece, or of the first DataArray in it if `name` is empty.
  template <class To>
  std::vector<To> values(std::string_view section, std::string_view name) {
    const std::size_t begin = xml_.find(std::string("<").append(section), begin_);
    const std::size_t end = xml_.find(std::string("</").append(section), begin);
    if (begin >= end_ || end >= end_) fail_(std::string("it has no section ").append(section));
    for (std::size_t at = xml_.find("<DataArray", begin); at < end; at = xml_.find("<DataArray", at + 1)) {
      const std::string_view tag = tag_at(at);
      if (!name.empty() && attribute(tag, "Name") != name) continue;
      const std::string_view type = attribute(tag, "type"), format = attribute(tag, "format");
      if (format == "ascii") {
        std::vector<To> values;
        const std::size_t text = at + tag.size();
        Cursor cursor(xml_.substr(text, xml_.find('<', text) - text), fail_);
        while (!cursor.at_end()) values.push_back(converted_to<To>(cursor.number<double>()));
        return values;
      }
      if (format != "appended" || !raw_) fail_("its data is encoded as base64");
      const std::string_view block = block_at(attribute(tag, "offset"));
      if (type == "Float32") return raw_values<float, To>(block);
      if (type == "Float64") return raw_values<double, To>(block);
      if (type == "Int32") return raw_values<std::int32_t, To>(block);
      if (type == "Int64") return raw_values<std::int64_t, To>(block);
      fail_(std::string("its data type ").append(in_quotes(type)).append(" is not supported"));
    }
    fail_(std::string("its section ").append(section).append(" has no data"));
    return {};
  }

 private:
  std::string_view tag_at(std::size_t at) const { return bytes_.substr(at, bytes_.find('>', at) + 1 - at); }

  std::string_view block_at(std::string_view offset) const {
    const auto start = number_of<std::uint64_t>(offset);
    const bool wide = attribute(root_, "header_type") == "UInt64";
    const std::size_t head = wide ? 8 : 4;
    if (!start || data_ == 0 || *start > bytes_.size() || data_ + 1 + *start + head > bytes_.size()) fail_(kTruncated);
    const std::size_t at = data_ + 1 + *start;
    std::uint64_t size = 0;
    std::memcpy(&size, bytes_.data() + at, head);
    if (size > bytes_.size() - at - head) fail_(kTruncated);
    return bytes_.substr(at + head, size);
  }

  std::string_view bytes_, xml_, root_;  // the file, its part before the appended data, its first tag
  const Fail& fail_;
  std::size_t data_ = 0, begin_ = 0, end_ = 0;  // begin of the appended data, piece
  bool raw_ = false;
};

}  // namespace

PolygonSurface surface_of_stl(const std::string& bytes, const Fail& fail) {
  PolygonSurface surface;
  std::uint32_t count = 0;
  if (bytes.size() >= 84) std::memcpy(&count, bytes.data() + 80, sizeof count);
  const bool binary = bytes.size() >= 84 && bytes.size() == 84 + 50 * std::size_t(count);
  const auto add = [&](const Eigen::Vector3f& p) {
    surface.polygons.vertices.push_back(static_cast<int>(surface.positions.size()));
    surface.positions.push_back(p);
    if (surface.positions.size() % 3 == 0)
      surface.polygons.offsets.push_back(static_cast<int>(surface.positions.size()));
  };
  if (binary) {
    for (std::uint32_t t = 0; t < count; ++t)
      for (int corner = 1; corner < 4; ++corner) {
        std::array<float, 3> p;
        std::memcpy(p.data(), bytes.data() + 84 + 50 * std::size_t(t) + 12 * std::size_t(corner), sizeof p);
        add({p[0], p[1], p[2]});
      }
  } else if (bytes.starts_with("solid")) {
    Cursor cursor(bytes, fail);
    cursor.line();
    while (!cursor.at_end()) {
      if (cursor.word() != "vertex") continue;
      const float x = cursor.number<float>(), y = cursor.number<float>();
      add({x, y, cursor.number<float>()});
    }
    if (surface.positions.size() % 3 != 0) fail(kTruncated);
  } else {
    fail("its size does not match the " + std::to_string(count) + " triangles in its header");
  }
  if (states_ras(std::string_view(bytes).substr(0, 80))) convert_from_ras(surface.positions);
  return surface;
}

PolygonSurface surface_of_obj(const std::string& bytes, const Fail& fail) {
  PolygonSurface surface;
  Cursor file(bytes, fail);
  std::string comments;
  std::vector<std::vector<long long>> faces;
  while (!file.at_end()) {
    const std::string_view text = file.line();
    Cursor line(text, fail);
    const std::string_view kind = line.word();
    if (kind.starts_with('#') && comments.size() < 10000) comments.append(text).append("\n");
    if (kind == "v") {
      const float x = line.number<float>(), y = line.number<float>();
      surface.positions.emplace_back(x, y, line.number<float>());
    }
    if (kind != "f") continue;
    std::vector<long long>& corners = faces.emplace_back();
    while (!line.at_end()) {
      const std::string_view corner = line.word();
      const auto number = number_of<long long>(corner.substr(0, corner.find('/')));
      if (!number || *number == 0) fail(in_quotes(corner) + " is not a point number");
      corners.push_back(*number > 0 ? *number - 1 : static_cast<long long>(surface.positions.size()) + *number);
    }
  }
  for (const auto& corners : faces) add_polygon(surface, corners, fail);
  if (states_ras(comments)) convert_from_ras(surface.positions);
  return surface;
}

PolygonSurface surface_of_vtk(const std::string& bytes, const Fail& fail) {
  PolygonSurface surface;
  Cursor cursor(bytes, fail);
  if (!cursor.line().starts_with("# vtk DataFile")) fail("it is not a VTK file");
  const std::string_view title = cursor.line(), coding = cursor.word();
  const bool binary = coding == "BINARY";
  if (!binary && coding != "ASCII") fail("it is neither ASCII nor BINARY");
  if (cursor.word() != "DATASET" || cursor.word() != "POLYDATA") fail("it contains no polydata");
  std::string_view space;  // the field SPACE of 3D Slicer; a binary string is preceded by its length
  while (!cursor.at_end()) {
    const std::string_view section = cursor.word();
    if (section == "POINT_DATA" || section == "CELL_DATA") break;
    if (section == "POINTS") {
      const auto count = cursor.number<std::uint64_t>();
      const std::string_view type = cursor.word();
      cursor.line();
      if (count > cursor.left()) fail(kTruncated);
      for (std::uint64_t n = 0; n < count; ++n) {
        Eigen::Vector3f& p = surface.positions.emplace_back();
        for (int a = 0; a < 3; ++a) p[a] = vtk_value<float>(cursor, type, binary, fail);
      }
    } else if (section == "POLYGONS" || section == "TRIANGLE_STRIPS" || section == "VERTICES" || section == "LINES") {
      const VtkCells cells = vtk_cells(cursor, binary, fail);
      if (section == "POLYGONS") add_polygons(surface, cells.ends, cells.corners, fail);
      if (section == "TRIANGLE_STRIPS") add_strips(surface, cells.ends, cells.corners, fail);
    } else if (section == "SPACE") {
      cursor.line();
      space = cursor.word();
    } else if (section != "METADATA") {
      cursor.line();
    }
  }
  if (states_ras(title) || space.ends_with("RAS")) convert_from_ras(surface.positions);
  return surface;
}

PolygonSurface surface_of_vtp(const std::string& bytes, const Fail& fail) {
  VtpReader reader(bytes, fail);
  PolygonSurface surface;
  while (reader.next_piece()) {
    if (reader.is_zero("NumberOfPoints", false)) continue;
    const auto first = static_cast<long long>(surface.positions.size());
    const auto points = reader.values<float>("Points", "");
    for (std::size_t n = 0; n + 2 < points.size(); n += 3)
      surface.positions.emplace_back(points[n], points[n + 1], points[n + 2]);
    const auto corners = [&](const char* section) {
      std::vector<long long> indices = reader.values<long long>(section, "connectivity");
      const auto count = static_cast<long long>(surface.positions.size()) - first;
      for (long long& index : indices) {
        if (index < 0 || index >= count)
          fail("a polygon refers to point " + std::to_string(index) + " of " + std::to_string(count));
        index += first;
      }
      return indices;
    };
    if (!reader.is_zero("NumberOfPolys", false))
      add_polygons(surface, reader.values<long long>("Polys", "offsets"), corners("Polys"), fail);
    if (!reader.is_zero("NumberOfStrips", true))
      add_strips(surface, reader.values<long long>("Strips", "offsets"), corners("Strips"), fail);
  }
  if (states_ras(std::string_view(bytes).substr(0, 1000)) || reader.field_text("SPACE").starts_with("RAS"))
    convert_from_ras(surface.positions);
  return surface;
}

}  // namespace simplexseg
