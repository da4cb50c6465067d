// SPDX-License-Identifier: Apache-2.0
// Format: http://paulbourke.net/dataformats/ply/
#include "io/mesh/ply.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <sstream>
#include <vector>

#include "core/number_text.h"
#include "io/mesh/mesh_formats.h"
#include "io/mesh/polygon_surface.h"
#include "io/platform/bytes.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"

namespace simplexseg {

static_assert(std::endian::native == std::endian::little, "the writers store the machine's own byte order");

namespace {

enum class Number { Int8, UInt8, Int16, UInt16, Int32, UInt32, Float32, Float64 };

std::optional<Number> number_named(const std::string& name) {
  const char* const names[8][2] = {{"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
                                   {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};
  for (int i = 0; i < 8; ++i) {
    if (name == names[i][0] || name == names[i][1]) return static_cast<Number>(i);
  }
  return {};
}

struct Property {
  std::string name;
  Number type = Number::Float32;
  std::optional<Number> count_type;  ///< type of the length of a list; nullopt for a single number
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

class PlyReader {
 public:
  PlyReader(const std::string& bytes, const std::string& name) : bytes_(bytes), name_(name) { read_header(); }

  const std::vector<PlyElement>& elements() const { return elements_; }
  /// Whether a comment states that the positions are RAS instead of LPS.
  bool is_ras() const { return ras_; }

  /// Reads the next number of the body.
  double number(Number type) {
    switch (type) {
      case Number::Int8:
        return value<std::int8_t>();
      case Number::UInt8:
        return value<std::uint8_t>();
      case Number::Int16:
        return value<std::int16_t>();
      case Number::UInt16:
        return value<std::uint16_t>();
      case Number::Int32:
        return value<std::int32_t>();
      case Number::UInt32:
        return value<std::uint32_t>();
      case Number::Float32:
        return value<float>();
      case Number::Float64:
        break;
    }
    return value<double>();
  }

  /// Reads the next number of the body as an index or count. Throws Error unless it is whole, at least 0 and below
  /// `limit`.
  int index(Number type, double limit) {
    const double number = this->number(type);
    if (!(number >= 0 && number < limit && number == std::floor(number)))
      fail("the index or count " + general_text(number, 10) + " is out of range");
    return static_cast<int>(number);
  }

  [[noreturn]] void fail(const std::string& why) const {
    throw Error("cannot read " + name_, one_line(why), "save the mesh again with the program that created it");
  }

 private:
  std::string line() {
    const std::size_t end = bytes_.find('\n', at_);
    if (end == std::string::npos || end - at_ > 4096) fail("it has no PLY header");
    std::string text = bytes_.substr(at_, end - at_);
    at_ = end + 1;
    if (!text.empty() && text.back() == '\r') text.pop_back();
    return text;
  }

  void read_header() {
    if (line() != "ply") fail("it is not a PLY file");
    bool has_format = false;
    for (std::string text = line(); text != "end_header"; text = line()) {
      std::istringstream words(text);
      std::string word, first, second, third;
      words >> word >> first;
      if (word == "format") {
        has_format = true;
        ascii_ = first == "ascii";
        swapped_ = first == "binary_big_endian";
        if (!ascii_ && !swapped_ && first != "binary_little_endian") fail("its format '" + first + "' is unknown");
      } else if (word == "comment") {
        ras_ = ras_ || states_ras(text);
        if (first == "frame") words >> second;
        if (first == "frame" && !second.starts_with("LPS"))
          fail("its coordinate system is '" + second + "' instead of LPS");
      } else if (word == "element") {
        PlyElement element;
        element.name = first;
        if (!(words >> element.count)) fail("its header has an element without a count");
        elements_.push_back(element);
      } else if (word == "property") {
        Property property;
        std::optional<Number> type = number_named(first);
        if (first == "list") {
          words >> second >> third;
          property.count_type = number_named(second);
          type = number_named(third);
          if (!property.count_type) fail("its header has a list of an unknown type");
        }
        if (!type || !(words >> property.name) || elements_.empty()) {
          fail("its header has an unknown property: '" + text + "'");
        }
        property.type = *type;
        elements_.back().properties.push_back(property);
      }
    }
    if (!has_format) fail("its header has no format");
  }

  template <class T>
  T value() {
    if (ascii_) {
      while (at_ < bytes_.size() && std::strchr(" \t\r\n", bytes_[at_])) ++at_;
      const std::size_t end = std::min(bytes_.find_first_of(" \t\r\n", at_), bytes_.size());
      const std::string word = bytes_.substr(at_, std::min<std::size_t>(end - at_, 40));
      const std::optional<double> number = number_of<double>(word);
      if (word.empty()) fail("truncated: it ends within its elements");
      if (!number || end - at_ > word.size()) fail("'" + word + "' is not a number");
      at_ = end;
      if constexpr (std::is_integral_v<T>) {
        if (!(*number >= double(std::numeric_limits<T>::min()) && *number <= double(std::numeric_limits<T>::max())))
          fail("a number is out of range for its type");
        if (*number != std::floor(*number)) fail("'" + word + "' is not a whole number");
      }
      return static_cast<T>(*number);
    }
    if (bytes_.size() - at_ < sizeof(T)) fail("truncated: it ends within its elements");
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if (swapped_) std::reverse(raw.begin(), raw.end());
    return std::bit_cast<T>(raw);
  }

  const std::string& bytes_;
  const std::string name_;
  std::size_t at_ = 0;
  bool ascii_ = false, swapped_ = false, ras_ = false;
  std::vector<PlyElement> elements_;
};

/// Index of a name in a list of three; -1 if the list does not contain it.
int index_of(const char* const (&names)[3], const std::string& name) {
  for (int i = 0; i < 3; ++i) {
    if (name == names[i]) return i;
  }
  return -1;
}

bool same_cycle(const std::array<int, 3>& a, std::array<int, 3> b) {
  for (int turn = 0; turn < 3; ++turn) {
    if (a == b) return true;
    std::rotate(b.begin(), b.begin() + 1, b.end());
  }
  return false;
}

}  // namespace

std::string ply_of(const SimplexMesh& mesh) {
  const CellList cells = cells_of(mesh);
  std::size_t longest = 0;
  for (int c = 0; c < cells.count(); ++c) longest = std::max(longest, cells[c].size());
  const bool small = longest <= 255;
  std::ostringstream header;
  header
      << "ply\nformat binary_little_endian 1.0\ncomment " << mesh_frame << "\ncomment " << mesh_space
      << "\ncomment simplex mesh: every vertex has the neighbours n1 n2 n3, counter-clockwise from outside\nelement "
         "vertex "
      << mesh.positions.size()
      << "\nproperty float x\nproperty float y\nproperty float z\nproperty int n1\nproperty int n2\nproperty int n3\n"
      << "element face " << cells.count() << "\nproperty list " << (small ? "uchar" : "int")
      << " int vertex_indices\nend_header\n";
  std::string bytes = header.str();
  bytes.reserve(bytes.size() + 24 * mesh.positions.size() + 4 * cells.vertices.size() + 4 * std::size_t(cells.count()));
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    for (int a = 0; a < 3; ++a) append(bytes, mesh.positions[v][a]);
    for (int n : mesh.neighbours[v]) append(bytes, std::int32_t(n));
  }
  for (int c = 0; c < cells.count(); ++c) {
    const auto cell = cells[c];
    small ? append(bytes, std::uint8_t(cell.size())) : append(bytes, std::int32_t(cell.size()));
    for (int v : cell) append(bytes, std::int32_t(v));
  }
  return bytes;
}

SimplexMesh mesh_of_ply(const std::string& bytes, const std::string& name) {
  PlyReader reader(bytes, name);
  SimplexMesh mesh;
  CellList polygons;
  bool written_neighbours = false, has_faces = false;
  std::uint64_t vertex_count = 0;
  for (const PlyElement& element : reader.elements()) {
    if (element.name == "vertex") vertex_count = element.count;
  }
  if (vertex_count > bytes.size())
    reader.fail("truncated: its header announces " + std::to_string(vertex_count) + " vertices");
  for (const PlyElement& element : reader.elements()) {
    const bool is_vertex = element.name == "vertex", is_face = element.name == "face";
    if (is_vertex) {
      const char* const names[] = {"x", "y", "z", "n1", "n2", "n3"};
      const auto has = [&](const char* n) {
        return std::any_of(element.properties.begin(), element.properties.end(),
                           [&](const Property& p) { return p.name == n && !p.count_type; });
      };
      if (!std::all_of(names, names + 3, has)) reader.fail("its vertices have no x, y, z");
      written_neighbours = std::all_of(names + 3, names + 6, has);
      mesh.positions.reserve(element.count);
    }
    for (std::uint64_t i = 0; i < element.count && !element.properties.empty(); ++i) {
      Eigen::Vector3f position(0, 0, 0);
      std::array<int, 3> neighbours{0, 0, 0};
      for (const Property& property : element.properties) {
        if (property.count_type) {
          const bool cell = is_face && property.name.starts_with("vertex_ind");  // _indices, _index
          const int length = reader.index(*property.count_type, 1e9);
          for (int n = 0; n < length; ++n) {
            if (cell)
              polygons.vertices.push_back(reader.index(property.type, double(vertex_count)));
            else
              reader.number(property.type);
          }
          if (cell) polygons.offsets.push_back(static_cast<int>(polygons.vertices.size()));
          has_faces |= cell;
        } else if (const int a = is_vertex ? index_of({"x", "y", "z"}, property.name) : -1; a >= 0) {
          position[a] = static_cast<float>(reader.number(property.type));
        } else if (const int n = is_vertex ? index_of({"n1", "n2", "n3"}, property.name) : -1; n >= 0) {
          neighbours[n] = reader.index(property.type, double(vertex_count));
        } else {
          reader.number(property.type);
        }
      }
      if (is_vertex) {
        mesh.positions.push_back(position);
        mesh.neighbours.push_back(neighbours);
      }
    }
  }
  if (mesh.positions.empty()) reader.fail("it has no vertices");
  if (reader.is_ras()) convert_from_ras(mesh.positions);
  if (!has_faces && !written_neighbours) reader.fail("it has no polygons");
  const auto fail = [&](const std::string& why) { reader.fail(why + ", so it is not a simplex mesh"); };
  PolygonSurface surface{mesh.positions, std::move(polygons)};
  if (!written_neighbours)
    return simplex_mesh_of(std::move(surface), [&](const std::string& why) { reader.fail(why); });
  if (has_faces) {
    const auto found = neighbours_of(surface, fail);
    for (std::size_t v = 0; v < found.size(); ++v) {
      if (!same_cycle(mesh.neighbours[v], found[v])) {
        fail("the neighbours of vertex " + std::to_string(v) + " disagree with the polygons");
      }
    }
  }
  return mesh;
}

}  // namespace simplexseg
