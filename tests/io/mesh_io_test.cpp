// SPDX-License-Identifier: Apache-2.0
#include "io/mesh/mesh_io.h"

#include <Eigen/Geometry>

#include <bit>
#include <cstring>
#include <map>
#include <set>
#include <sstream>

#include "mesh/mesh_geometry.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::bytes_of;
using test::error_of;

class MeshIo : public test::FolderTest {};

/// Sphere whose positions use all bits of a float.
SimplexMesh rough_sphere() {
  SimplexMesh mesh = make_sphere({12.3, -45.6, 78.9}, 17.7, 2);
  for (int v = 0; v < mesh.vertex_count(); ++v) mesh.positions[v] *= 1 + 1e-3f * std::sin(float(v));
  return mesh;
}

bool same_mesh(const SimplexMesh& a, const SimplexMesh& b) {
  return a.positions.size() == b.positions.size() && a.neighbours == b.neighbours &&
         std::memcmp(a.positions.data(), b.positions.data(), a.positions.size() * sizeof a.positions[0]) == 0;
}

TEST_F(MeshIo, PlyIsLossless) {
  const SimplexMesh mesh = rough_sphere();
  write_mesh(folder / "a.ply", mesh);
  EXPECT_TRUE(same_mesh(mesh, read_mesh(folder / "a.ply")));
  const std::string header = bytes_of(folder / "a.ply").substr(0, 300);
  EXPECT_HAS(header, "format binary_little_endian 1.0");
  EXPECT_HAS(header, "comment frame LPS, unit mm");
}

TEST_F(MeshIo, PlyOfARefinedMeshIsLossless) {
  const SimplexMesh mesh = refine(make_ellipsoid({0, 0, 0}, {10, 20, 30}, 1)).mesh;
  write_mesh(folder / "a.ply", mesh);
  EXPECT_TRUE(same_mesh(mesh, read_mesh(folder / "a.ply")));
}

/// Without n1 n2 n3 the same neighbours must follow from the polygons.
TEST_F(MeshIo, NeighboursAreComputedFromPolygons) {
  const SimplexMesh mesh = rough_sphere();
  const CellList cells = cells_of(mesh);
  std::ostringstream text;
  text.precision(9);
  text << "ply\r\nformat ascii 1.0\r\ncomment made by hand\r\nelement vertex " << mesh.vertex_count()
       << "\r\nproperty double x\r\nproperty double y\r\nproperty double z\r\nproperty uchar red\r\nelement face "
       << cells.count() << "\r\nproperty uchar flags\r\nproperty list uchar int vertex_index\r\nend_header\r\n";
  for (const auto& p : mesh.positions) text << p[0] << ' ' << p[1] << ' ' << p[2] << " 255\r\n";
  for (int c = 0; c < cells.count(); ++c) {
    text << "0 " << cells[c].size();
    for (int v : cells[c]) text << ' ' << v;
    text << "\r\n";
  }
  const SimplexMesh read = read_mesh(write("a.ply", text.str()));
  ASSERT_EQ(read.vertex_count(), mesh.vertex_count());
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_EQ(read.positions[v], mesh.positions[v]);
    auto n = read.neighbours[v];
    while (n[0] != mesh.neighbours[v][0]) std::rotate(n.begin(), n.begin() + 1, n.end());
    EXPECT_EQ(n, mesh.neighbours[v]);
  }
}

TEST_F(MeshIo, InvalidPlyIsRejected) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10, 1);
  write_mesh(folder / "good.ply", mesh);
  const std::string good = bytes_of(folder / "good.ply");
  const std::size_t body = good.find("end_header\n") + 11;
  const auto read = [&](const std::string& bytes) { return error_of([&] { read_mesh(write("bad.ply", bytes)); }); };
  for (const std::size_t size : {std::size_t(3), body / 2, body, body + 7, (good.size() + body) / 2, good.size() - 1}) {
    EXPECT_HAS(read(good.substr(0, size)), "bad.ply");
  }
  EXPECT_HAS(read(good.substr(0, good.size() - 1)), "truncated");
  EXPECT_HAS(read("solid text\n"), "not a PLY");
  std::string wrong = good;
  wrong.replace(wrong.find("frame LPS"), 9, "frame RAS");
  EXPECT_HAS(read(wrong), "RAS");
  // Two exchanged neighbours disagree with the polygons.
  wrong = good;
  std::swap_ranges(wrong.begin() + body + 12, wrong.begin() + body + 16, wrong.begin() + body + 16);
  EXPECT_HAS(read(wrong), "polygons");
  // A non-finite position.
  wrong = good;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::memcpy(&wrong[body], &nan, 4);
  EXPECT_HAS(read(wrong), "finite");
  wrong = good;
  wrong.replace(wrong.find("element vertex 80"), 17, "element vertex 99999999999");
  EXPECT_HAS(read(wrong), "truncated");
  EXPECT_HAS(error_of([&] { read_mesh(folder / "none.ply"); }), "no such file");
  EXPECT_HAS(error_of([&] { read_mesh(folder); }), "not a file");
  EXPECT_HAS(error_of([&] { read_mesh(write("a.xyz", good)); }), ".ply");
}

TEST_F(MeshIo, CorruptedFilesAreReadOrRejected) {
  write_mesh(folder / "good.ply", make_sphere({0, 0, 0}, 10, 0));
  const std::string good = bytes_of(folder / "good.ply");
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bytes = good;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    try {
      validate(read_mesh(write("bad.ply", bytes)));
    } catch (const Error& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  }
}

TEST_F(MeshIo, ObjContainsTheCells) {
  const SimplexMesh mesh = rough_sphere();
  write_mesh(folder / "a.obj", mesh);
  std::ifstream stream(folder / "a.obj");
  const CellList cells = cells_of(mesh);
  int vertices = 0, faces = 0;
  bool frame = false;
  for (std::string line; std::getline(stream, line);) {
    std::istringstream words(line);
    std::string kind;
    words >> kind;
    frame |= line.find("frame LPS, unit mm") != std::string::npos;
    if (kind == "v") {
      Eigen::Vector3f p;
      words >> p[0] >> p[1] >> p[2];
      EXPECT_EQ(p, mesh.positions[vertices++]);
    } else if (kind == "f") {
      for (int v : cells[faces]) {
        int read = 0;
        words >> read;
        EXPECT_EQ(read, v + 1);
      }
      ++faces;
    }
  }
  EXPECT_TRUE(frame);
  EXPECT_EQ(vertices, mesh.vertex_count());
  EXPECT_EQ(faces, cells.count());
}

TEST_F(MeshIo, StlIsClosedAndOutward) {
  const SimplexMesh mesh = rough_sphere();
  write_mesh(folder / "a.stl", mesh);
  const std::string bytes = bytes_of(folder / "a.stl");
  std::uint32_t count = 0;
  std::memcpy(&count, &bytes[80], 4);
  EXPECT_EQ(count, 3u * mesh.vertex_count());
  ASSERT_EQ(bytes.size(), 84 + 50 * std::size_t(count));
  EXPECT_FALSE(bytes.starts_with("solid"));
  double volume = 0;
  std::map<std::string, int> edges;  // sum over the two directions: 0 for a closed surface
  for (std::uint32_t t = 0; t < count; ++t) {
    Eigen::Vector3f p[4];
    std::memcpy(static_cast<void*>(p), &bytes[84 + 50 * t], 48);
    const Eigen::Vector3d a = p[1].cast<double>(), b = p[2].cast<double>(), c = p[3].cast<double>();
    volume += a.dot(b.cross(c)) / 6;
    EXPECT_GT(p[0].cast<double>().dot((b - a).cross(c - a)), 0);
    for (int side = 0; side < 3; ++side) {
      const std::string from(reinterpret_cast<char*>(&p[1 + side]), 12),
          to(reinterpret_cast<char*>(&p[1 + (side + 1) % 3]), 12);
      ++edges[from + to];
      --edges[to + from];
    }
  }
  for (const auto& [edge, sum] : edges) EXPECT_EQ(sum, 0);
  EXPECT_NEAR(volume, measure(mesh).volume_mm3, 1e-3 * volume);
}

TEST_F(MeshIo, VtkAndVtpContainPointsAndCells) {
  const SimplexMesh mesh = rough_sphere();
  const CellList cells = cells_of(mesh);
  write_mesh(folder / "a.vtk", mesh);
  std::string bytes = bytes_of(folder / "a.vtk");
  const std::string points = "POINTS " + std::to_string(mesh.vertex_count()) + " float\n";
  const std::string polygons =
      "POLYGONS " + std::to_string(cells.count()) + " " + std::to_string(cells.count() + cells.vertices.size()) + "\n";
  ASSERT_NE(bytes.find(points), std::string::npos);
  ASSERT_NE(bytes.find(polygons), std::string::npos);
  const auto big_endian = [&](std::size_t at) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
    return value;
  };
  std::size_t at = bytes.find(points) + points.size();
  for (const auto& p : mesh.positions) {
    for (int a = 0; a < 3; ++a, at += 4) ASSERT_EQ(std::bit_cast<float>(big_endian(at)), p[a]);
  }
  at = bytes.find(polygons) + polygons.size();
  for (int c = 0; c < cells.count(); ++c) {
    ASSERT_EQ(big_endian(at), cells[c].size());
    at += 4;
    for (int v : cells[c]) {
      ASSERT_EQ(int(big_endian(at)), v);
      at += 4;
    }
  }
  EXPECT_EQ(at + 1, bytes.size());

  write_mesh(folder / "a.vtp", mesh);
  bytes = bytes_of(folder / "a.vtp");
  EXPECT_HAS(bytes.substr(0, 200), "frame LPS, unit mm");
  const std::size_t data = bytes.find("encoding=\"raw\">\n_") + 17;
  const auto block = [&](const std::string& before) {  // block whose offset follows `before`
    const std::size_t offset = std::stoul(bytes.substr(bytes.find("offset=\"", bytes.find(before)) + 8));
    std::uint64_t size = 0;
    std::memcpy(&size, &bytes[data + offset], 8);
    return bytes.substr(data + offset + 8, size);
  };
  const std::string read_points = block("<Points>"), ids = block("connectivity"), ends = block("\"offsets\"");
  ASSERT_EQ(read_points.size(), 12 * mesh.positions.size());
  EXPECT_EQ(std::memcmp(read_points.data(), mesh.positions.data(), read_points.size()), 0);
  ASSERT_EQ(ids.size(), 4 * cells.vertices.size());
  EXPECT_EQ(std::memcmp(ids.data(), cells.vertices.data(), ids.size()), 0);
  ASSERT_EQ(ends.size(), 4 * std::size_t(cells.count()));
  EXPECT_EQ(std::memcmp(ends.data(), cells.offsets.data() + 1, ends.size()), 0);
}

TEST_F(MeshIo, InvalidTargetsAndMeshesAreRejected) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10, 0);
  const std::string unknown = error_of([&] { write_mesh(folder / "a.xyz", mesh); });
  for (const char* extension : {".ply", ".obj", ".stl", ".vtk", ".vtp"}) EXPECT_HAS(unknown, extension);
  error_of([&] { write_mesh(folder / "a", mesh); });
  EXPECT_HAS(error_of([&] { write_mesh(folder / "none" / "a.ply", mesh); }), "does not exist");
  error_of([&] { write_mesh(folder / "a.ply", SimplexMesh{}); });
  SimplexMesh broken = mesh;
  broken.neighbours[3][1] = 3;
  error_of([&] { write_mesh(folder / "a.ply", broken); });
  EXPECT_TRUE(std::filesystem::is_empty(folder));
}

TEST_F(MeshIo, WritingReplacesTheWholeFile) {
  write("a.ply", std::string(1 << 20, 'x'));
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10, 0);
  write_mesh(folder / "a.ply", mesh);
  EXPECT_TRUE(same_mesh(mesh, read_mesh(folder / "a.ply")));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

}  // namespace
}  // namespace simplexseg
