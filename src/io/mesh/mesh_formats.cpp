// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/mesh_formats.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <sstream>

#include "io/platform/bytes.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

/// Appends the shortest decimal that reads back as the same float.
void append_text(std::string& to, float value) {
  char text[32];
  const auto result = std::to_chars(text, text + sizeof text, value);
  to.append(text, result.ptr);
}

template <class T>
void append_big_endian(std::string& to, T value) {
  append(to, value);
  std::reverse(to.end() - sizeof(T), to.end());
}

}  // namespace

std::string obj_of(const SimplexMesh& mesh) {
  std::string text = std::string("# simplex mesh, ") + mesh_frame + "\n# " + mesh_space + "\n";
  for (const Eigen::Vector3f& p : mesh.positions) {
    text += 'v';
    for (int a = 0; a < 3; ++a) {
      text += ' ';
      append_text(text, p[a]);
    }
    text += '\n';
  }
  const CellList cells = cells_of(mesh);
  for (int c = 0; c < cells.count(); ++c) {
    text += 'f';
    for (int v : cells[c]) {
      text += ' ';
      text += std::to_string(v + 1);
    }
    text += '\n';
  }
  return text;
}

std::string stl_of(const SimplexMesh& mesh) {
  const TriangleMesh surface = tessellate(mesh);
  std::string bytes = std::string("binary STL of a simplex mesh, ") + mesh_frame + ", " + mesh_space;
  bytes.resize(80, ' ');
  append(bytes, std::uint32_t(surface.triangles.size()));
  bytes.reserve(84 + 50 * surface.triangles.size());
  for (const auto& t : surface.triangles) {
    const Eigen::Vector3f &a = surface.positions[t[0]], &b = surface.positions[t[1]], &c = surface.positions[t[2]];
    const Eigen::Vector3f normal = (b - a).cross(c - a).stableNormalized();
    for (const Eigen::Vector3f* p : {&normal, &a, &b, &c}) {
      for (int i = 0; i < 3; ++i) append(bytes, (*p)[i]);
    }
    append(bytes, std::uint16_t(0));
  }
  return bytes;
}

std::string vtk_of(const SimplexMesh& mesh) {
  const CellList cells = cells_of(mesh);
  std::string bytes = std::string("# vtk DataFile Version 3.0\nsimplex mesh, ") + mesh_frame + ", " + mesh_space +
                      "\nBINARY\nDATASET POLYDATA\nPOINTS " + std::to_string(mesh.positions.size()) + " float\n";
  for (const Eigen::Vector3f& p : mesh.positions) {
    for (int a = 0; a < 3; ++a) append_big_endian(bytes, p[a]);
  }
  bytes += "\nPOLYGONS " + std::to_string(cells.count()) + ' ' +
           std::to_string(cells.vertices.size() + std::size_t(cells.count())) + '\n';
  for (int c = 0; c < cells.count(); ++c) {
    append_big_endian(bytes, std::int32_t(cells[c].size()));
    for (int v : cells[c]) append_big_endian(bytes, std::int32_t(v));
  }
  bytes += '\n';
  return bytes;
}

std::string vtp_of(const SimplexMesh& mesh) {
  // https://docs.vtk.org/en/latest/design_documents/VTKFileFormats.html: each block of raw data is preceded by its
  // size.
  const CellList cells = cells_of(mesh);
  const std::uint64_t points = 12 * mesh.positions.size(), ids = 4 * cells.vertices.size(),
                      ends = 4 * std::uint64_t(cells.count());
  std::ostringstream header;
  header
      << "<?xml version=\"1.0\"?>\n<!-- simplex mesh, " << mesh_frame << ", " << mesh_space << " -->\n"
      << "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n"
      << "<Piece NumberOfPoints=\"" << mesh.positions.size() << "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
      << "NumberOfStrips=\"0\" NumberOfPolys=\"" << cells.count() << "\">\n"
      << "<Points><DataArray type=\"Float32\" NumberOfComponents=\"3\" format=\"appended\" offset=\"0\"/></Points>\n"
      << "<Polys><DataArray type=\"Int32\" Name=\"connectivity\" format=\"appended\" offset=\"" << points + 8 << "\"/>"
      << "<DataArray type=\"Int32\" Name=\"offsets\" format=\"appended\" offset=\"" << points + ids + 16
      << "\"/></Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  std::string bytes = header.str();
  append(bytes, points);
  for (const Eigen::Vector3f& p : mesh.positions) {
    for (int a = 0; a < 3; ++a) append(bytes, p[a]);
  }
  append(bytes, ids);
  for (int v : cells.vertices) append(bytes, std::int32_t(v));
  append(bytes, ends);
  for (int c = 0; c < cells.count(); ++c) append(bytes, std::int32_t(cells.offsets[c + 1]));
  bytes += "\n</AppendedData>\n</VTKFile>\n";
  return bytes;
}

}  // namespace simplexseg
