// SPDX-License-Identifier: Apache-2.0
// Import of surfaces of other programs as simplex meshes.
#include <algorithm>
#include <bit>
#include <sstream>

#include "core/number_text.h"
#include "image/label_surface.h"
#include "io/mesh/mesh_io.h"
#include "mesh/iso_surface.h"
#include "mesh/mesh_geometry.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::bytes_of;
using test::error_of;

class SurfaceFormats : public test::FolderTest {
 protected:
  static TriangleMesh torus() {
    const std::array<int, 3> size{30, 30, 12};
    std::vector<float> values;
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i)
          values.push_back(static_cast<float>(3.5 - std::hypot(std::hypot(i - 15.0, j - 14.0) - 8, k - 6.0)));
    return iso_surface(values, size, 0, Eigen::Affine3d::Identity());
  }
  static std::string obj(const TriangleMesh& surface, const std::string& comment = "") {
    std::ostringstream text;
    text << "# " << comment << "\no thing\n";
    for (const auto& p : surface.positions) text << "v " << p[0] << ' ' << p[1] << ' ' << p[2] << "\r\n";
    for (const auto& t : surface.triangles)
      text << "f " << t[0] + 1 << "/1/2 " << t[1] + 1 << "//3 " << t[2] + 1 << "\n";
    return text.str();
  }
  static std::string ascii_stl(const TriangleMesh& surface) {
    std::ostringstream text;
    text.precision(9);
    text << "solid thing\n";
    for (const auto& t : surface.triangles) {
      text << " facet normal 0 0 0\n  outer loop\n";
      for (const int v : t) text << "   vertex " << surface.positions[v].transpose() << "\n";
      text << "  endloop\n endfacet\n";
    }
    return text.str() + "endsolid thing\n";
  }
  static std::string vtk(const TriangleMesh& surface, bool five) {
    std::ostringstream text;
    const std::size_t count = surface.triangles.size();
    text << "# vtk DataFile Version " << (five ? "5.1" : "3.0") << "\nthing\nASCII\nDATASET POLYDATA\nPOINTS "
         << surface.positions.size() << " double\n";
    for (const auto& p : surface.positions) text << p.transpose() << "\n";
    text << "METADATA\nINFORMATION 0\n\n";
    if (five) {
      text << "POLYGONS " << count + 1 << ' ' << 3 * count << "\nOFFSETS vtktypeint64\n";
      for (std::size_t t = 0; t <= count; ++t) text << 3 * t << ' ';
      text << "\nCONNECTIVITY vtktypeint64\n";
      for (const auto& t : surface.triangles) text << t[0] << ' ' << t[1] << ' ' << t[2] << "\n";
    } else {
      text << "POLYGONS " << count << ' ' << 4 * count << "\n";
      for (const auto& t : surface.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << "\n";
    }
    return text.str();
  }
  static std::string ply(const TriangleMesh& surface) {
    std::ostringstream text;
    text << "ply\nformat ascii 1.0\nelement vertex " << surface.positions.size()
         << "\nproperty float x\nproperty float y\nproperty float z\nelement face " << surface.triangles.size()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (const auto& p : surface.positions) text << p.transpose() << "\n";
    for (const auto& t : surface.triangles) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << "\n";
    return text.str();
  }
  static std::string ascii_vtp(const TriangleMesh& surface) {
    std::ostringstream text;
    text << "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
            "byte_order=\"LittleEndian\">\n<PolyData>\n"
         << "<Piece NumberOfPoints=\"9\"><Points><DataArray type=\"Float32\" Name=\"Points\" NumberOfComponents=\"3\" "
            "format=\"ascii\">\n";
    for (const auto& p : surface.positions) text << p.transpose() << "\n";
    text << "</DataArray></Points>\n<Polys><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">";
    for (const auto& t : surface.triangles) text << t[0] << ' ' << t[1] << ' ' << t[2] << "\n";
    text << "</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">";
    for (std::size_t t = 1; t <= surface.triangles.size(); ++t) text << 3 * t << ' ';
    text << "</DataArray></Polys></Piece></PolyData></VTKFile>\n";
    return text.str();
  }
  std::string refusal(const std::string& name, const std::string& bytes) {
    return error_of([&] { read_mesh(write(name, bytes)); });
  }
};

TEST_F(SurfaceFormats, TriangulationsBecomeTheirDual) {
  const TriangleMesh surface = torus();
  const SimplexMesh dual = dual_of(surface);
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{{"a.obj", obj(surface)},
                                                                                    {"a.stl", ascii_stl(surface)},
                                                                                    {"a.vtk", vtk(surface, false)},
                                                                                    {"b.vtk", vtk(surface, true)},
                                                                                    {"a.vtp", ascii_vtp(surface)},
                                                                                    {"a.ply", ply(surface)}}) {
    const SimplexMesh mesh = read_mesh(write(name, bytes));
    ASSERT_EQ(mesh.vertex_count(), dual.vertex_count()) << name;
    for (int v = 0; v < mesh.vertex_count(); ++v)
      ASSERT_LT((mesh.positions[v] - dual.positions[v]).norm(), 1e-3) << name;
    EXPECT_EQ(topology_of(mesh).genus, 1) << name;
  }
}

TEST_F(SurfaceFormats, WrittenFilesAreReadAgain) {
  const SimplexMesh mesh = dual_of(torus());
  for (const char* name : {"a.obj", "a.vtk", "a.vtp", "a.ply"}) {
    write_mesh(folder / name, mesh);
    const SimplexMesh read = read_mesh(folder / name);
    EXPECT_EQ(read.positions, mesh.positions) << name << ": the cells are those of the mesh itself";
    EXPECT_EQ(cells_of(read).count(), cells_of(mesh).count());
  }
  write_mesh(folder / "a.stl", mesh);  // a triangulation; its dual has one vertex per triangle
  const SimplexMesh read = read_mesh(folder / "a.stl");
  EXPECT_EQ(read.vertex_count(), 3 * mesh.vertex_count());
  EXPECT_EQ(topology_of(read).genus, 1);
  EXPECT_NEAR(measure(read).volume_mm3 / measure(mesh).volume_mm3, 1, 0.01);
}

TEST_F(SurfaceFormats, InwardOrientationAndRasAreConverted) {
  TriangleMesh surface = torus();
  const SimplexMesh mesh = read_mesh(write("a.obj", obj(surface)));
  const SimplexMesh ras = read_mesh(write("r.obj", obj(surface, "SPACE=RAS")));
  EXPECT_LT((ras.positions[5] - mesh.positions[5].cwiseProduct(Eigen::Vector3f(-1, -1, 1))).norm(), 1e-5f);
  EXPECT_GT(measure(ras).volume_mm3, 0);
  for (auto& t : surface.triangles) std::swap(t[1], t[2]);
  EXPECT_NEAR(measure(read_mesh(write("i.obj", obj(surface)))).volume_mm3, measure(mesh).volume_mm3, 1e-3);
}

std::string with(std::string text, const std::string& before, const std::string& inserted) {
  const std::size_t at = text.find(before);
  EXPECT_NE(at, std::string::npos) << before;
  return text.insert(at, inserted);
}

TriangleMesh ball(const Eigen::Vector3d& centre, double radius, bool inward = false) {
  TriangleMesh surface = tessellate(make_sphere(centre, radius, 1));
  for (auto& t : surface.triangles)
    if (inward) std::swap(t[1], t[2]);
  return surface;
}

TriangleMesh joined(TriangleMesh a, const TriangleMesh& b) {
  const int first = static_cast<int>(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& t : b.triangles) a.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  return a;
}

double volume_of_ball(double radius) { return measure(make_sphere({0, 0, 0}, radius, 1)).volume_mm3; }

TEST_F(SurfaceFormats, EveryFormatStatesRas) {
  const TriangleMesh surface = ball({30, 20, 5}, 10);
  const std::vector<std::pair<std::string, std::string>> files{
      {"a.ply", with(ply(surface), "element vertex", "comment SPACE=RAS\n")},
      {"a.vtk", with(vtk(surface, false), "POINTS", "FIELD FieldData 1\nSPACE 1 1 string\nRAS\n")},
      {"b.vtk", with(vtk(surface, false), "POINTS", "FIELD FieldData 1\nSPACE 1 1 string\n\xc3RAS\n")},
      {"a.vtp", with(ascii_vtp(surface), "<Piece",
                     "<FieldData><DataArray type=\"String\" Name=\"SPACE\" format=\"ascii\">82 65 83 0</DataArray>"
                     "</FieldData>")},
      {"b.vtp", with(ascii_vtp(surface), "<PolyData>", "<!-- SPACE=RAS -->")}};
  for (const auto& [name, bytes] : files) {
    const Eigen::Vector3d centre = measure(read_mesh(write(name, bytes))).centroid_mm;
    EXPECT_LT((centre - Eigen::Vector3d(-30, -20, 5)).norm(), 0.01) << name << ": " << centre.transpose();
  }
  const std::string lps = with(ply(surface), "element vertex", "comment SPACE=LPS\n");
  EXPECT_NEAR(measure(read_mesh(write("l.ply", lps))).centroid_mm.x(), 30, 0.01);
}

TEST_F(SurfaceFormats, AllPiecesOfAVtpFileAreRead) {
  const std::string first = ascii_vtp(ball({30, 20, 5}, 10)), second = ascii_vtp(ball({0, 0, 0}, 5));
  const std::size_t begin = second.find("<Piece"), end = second.find("</PolyData>");
  const std::string more = second.substr(begin, end - begin) + "<Piece NumberOfPoints=\"0\"/>";
  const std::string both = with(first, "</PolyData>", more);
  const SimplexMesh mesh = read_mesh(write("a.vtp", both));
  EXPECT_NEAR(measure(mesh).volume_mm3 / (volume_of_ball(10) + volume_of_ball(5)), 1, 0.02);
  std::string beyond = both;
  const std::size_t array = beyond.find("Name=\"connectivity\"", beyond.find("</Piece>"));
  beyond.insert(beyond.find('>', array) + 1, "99999 ");
  EXPECT_HAS(refusal("b.vtp", beyond), "refers to point 99999");
}

TEST_F(SurfaceFormats, TriangleStripsAreRead) {
  const std::string points = "0 0 0\n10 0 0\n0 10 0\n0 0 10\n50 0 0\n60 0 0\n50 10 0\n50 0 10\n";
  const std::string file =
      "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 8 float\n" + points +
      "VERTICES 1 2\n1 0\nPOLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\nTRIANGLE_STRIPS 1 7\n6 4 6 5 7 4 6\n"
      "POINT_DATA 8\nSCALARS a float 1\nLOOKUP_TABLE default\n0 0 0 0 0 0 0 0\n";
  EXPECT_NEAR(measure(read_mesh(write("a.vtk", file))).volume_mm3, 1000.0 / 3, 0.02 * 1000 / 3);
  const std::string array = "<DataArray type=\"Int32\" Name=\"";
  const std::string vtp =
      "<VTKFile type=\"PolyData\" byte_order=\"LittleEndian\">\n<PolyData><Piece NumberOfPoints=\"8\" "
      "NumberOfPolys=\"0\" NumberOfStrips=\"2\"><Points><DataArray type=\"Float32\" format=\"ascii\">" +
      points + "</DataArray></Points><Strips>" + array +
      "connectivity\" format=\"ascii\">0 2 1 3 0 2 4 6 5 7 4 6</DataArray>" + array +
      "offsets\" format=\"ascii\">6 12</DataArray></Strips></Piece></PolyData></VTKFile>\n";
  EXPECT_NEAR(measure(read_mesh(write("a.vtp", vtp))).volume_mm3, 1000.0 / 3, 0.02 * 1000 / 3);
}

TEST_F(SurfaceFormats, EveryOutermostPartFacesOutward) {
  const auto volume = [&](const TriangleMesh& surface) {
    return measure(read_mesh(write("a.obj", obj(surface)))).volume_mm3;
  };
  const Eigen::Vector3d here(30, 20, 5), there(-10, 0, 0);
  const double large = volume_of_ball(10), small = volume_of_ball(5);
  for (const bool a : {false, true})
    for (const bool b : {false, true})
      EXPECT_NEAR(volume(joined(ball(here, 10, a), ball(there, 5, b))) / (large + small), 1, 0.02) << a << b;
  for (const bool a : {false, true})  // a cavity, also in a file that faces inward as a whole
    EXPECT_NEAR(volume(joined(ball(here, 10, a), ball(here, 5, !a))) / (large - small), 1, 0.025) << a;
  // A second part decides nothing about the first: the shell faces inward, the ball outward.
  const TriangleMesh shell = joined(ball(here, 10, true), ball(here, 5));
  EXPECT_NEAR(volume(joined(shell, ball(there, 5))) / large, 1, 0.02);
}

TEST_F(SurfaceFormats, CoarseSurfacesKeepTheirVolume) {
  TriangleMesh cube;
  for (const float z : {0.f, 10.f})
    for (const auto& [x, y] : {std::pair(0.f, 0.f), {10.f, 0.f}, {10.f, 10.f}, {0.f, 10.f}})
      cube.positions.emplace_back(x, y, z);
  cube.triangles = {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}, {0, 1, 5}, {0, 5, 4},
                    {1, 2, 6}, {1, 6, 5}, {2, 3, 7}, {2, 7, 6}, {3, 0, 4}, {3, 4, 7}};
  for (const auto& [name, bytes] : std::vector<std::pair<std::string, std::string>>{
           {"a.obj", obj(cube)}, {"a.stl", ascii_stl(cube)}, {"a.ply", ply(cube)}, {"a.vtp", ascii_vtp(cube)}})
    EXPECT_NEAR(measure(read_mesh(write(name, bytes))).volume_mm3, 1000, 20) << name;
}

TEST_F(SurfaceFormats, ConcavePolygonsAreSplitInside) {
  const std::vector<std::array<int, 2>> outline{{10, 10},  {10, 0},    {0, 0},    {0, 10},
                                                {-10, 10}, {-10, -10}, {20, -10}, {20, 10}};
  const int count = static_cast<int>(outline.size());
  std::ostringstream text, top, bottom;
  for (const int z : {0, 10})
    for (const auto& [x, y] : outline) text << "v " << x << ' ' << y << ' ' << z << "\n";
  for (int n = 0; n < count; ++n) {
    const int next = (n + 1) % count;
    text << "f " << n + 1 << ' ' << next + 1 << ' ' << next + count + 1 << "\nf " << n + 1 << ' ' << next + count + 1
         << ' ' << n + count + 1 << "\n";
    top << ' ' << n + count + 1;
    bottom << ' ' << count - n;
  }
  text << "f" << top.str() << "\nf" << bottom.str() << "\n";
  const SurfaceMeasures measures = measure(read_mesh(write("a.obj", text.str())));
  EXPECT_NEAR(measures.volume_mm3, 5000, 100);
  EXPECT_LT(measures.area_mm2, 1.01 * 2200);  // triangles beyond the outline would overlap others
  EXPECT_GT(measures.area_mm2, 0.9 * 2200);
}

TEST_F(SurfaceFormats, NumbersOutOfRange) {
  const std::string good = obj(ball({0, 0, 0}, 10));
  const std::size_t at = good.find("v ") + 2, end = good.find(' ', at);
  const auto replaced = [&](const std::string& number) { return std::string(good).replace(at, end - at, number); };
  EXPECT_NO_THROW(read_mesh(write("a.obj", replaced("-1.07797e-046"))));
  EXPECT_HAS(refusal("a.obj", replaced("1e39")), "'1e39' is not a number");
  const std::string text = ply(ball({0, 0, 0}, 10));
  const std::size_t first = text.find("end_header\n") + 11;
  EXPECT_HAS(refusal("a.ply", std::string(text).replace(first, text.find(' ', first) - first, "1e400")),
             "'1e400' is not a number");
}

TEST_F(SurfaceFormats, OpenAndNonManifoldSurfacesAreRejected) {
  TriangleMesh surface = torus();
  surface.triangles.pop_back();
  EXPECT_HAS(refusal("open.stl", ascii_stl(surface)), "has 1 triangle where a closed surface has two");
  surface = torus();
  std::swap(surface.triangles[7][0], surface.triangles[7][1]);
  EXPECT_HAS(refusal("sense.obj", obj(surface)), "opposite orientations");
  surface = torus();
  surface.triangles.push_back({surface.triangles[0][0], surface.triangles[0][1], 100});
  EXPECT_HAS(refusal("fin.vtk", vtk(surface, false)), "where a closed surface has two");
}

TEST_F(SurfaceFormats, DamagedFilesAreRejected) {
  const TriangleMesh surface = torus();
  EXPECT_HAS(refusal("a.stl", "no solid"), "triangles in its header");
  EXPECT_HAS(refusal("a.obj", "v 1 2 x\n"), "'x' is not a number");
  EXPECT_HAS(refusal("a.obj", "v 1 2 3\nf 1 2 3\n"), "refers to point");
  EXPECT_HAS(refusal("a.obj", "# nothing\n"), "no polygons");
  EXPECT_HAS(refusal("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET POLYDATA\nPOINTS 99999999999 float\n"),
             "truncated");
  EXPECT_HAS(refusal("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\n"), "no polydata");
  EXPECT_HAS(refusal("a.vtp", "<VTKFile type=\"PolyData\" compressor=\"vtkZLibDataCompressor\">"), "compressed");
  write_mesh(folder / "good.vtp", dual_of(surface));
  write_mesh(folder / "good.vtk", dual_of(surface));
  write_mesh(folder / "good.stl", dual_of(surface));
  for (const char* name : {"good.vtp", "good.vtk", "good.stl"}) {
    const std::string good = bytes_of(folder / name);
    for (const double share : {0.05, 0.3, 0.6, 0.95})
      refusal(std::string("bad").append(name), good.substr(0, static_cast<std::size_t>(share * double(good.size()))));
  }
}

TEST_F(SurfaceFormats, CorruptedFilesAreReadOrRejected) {
  const SimplexMesh mesh = make_sphere({0, 0, 0}, 10, 0);
  for (const char* name : {"a.obj", "a.stl", "a.vtk", "a.vtp"}) {
    write_mesh(folder / name, mesh);
    const std::string good = bytes_of(folder / name);
    for (std::size_t at = 0; at < good.size(); at += 3) {
      std::string bytes = good;
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at / 3 % 8)));
      try {
        validate(read_mesh(write(name, bytes)));
      } catch (const Error& error) {
        ASSERT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      }
    }
  }
}

}  // namespace
}  // namespace simplexseg
