// SPDX-License-Identifier: Apache-2.0
// Import of surfaces of other programs as simplex meshes.
#include <algorithm>
#include <bit>
#include <sstream>

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

TEST_F(SurfaceFormats, OpenAndNonManifoldSurfacesAreRejected) {
  TriangleMesh surface = torus();
  surface.triangles.pop_back();
  EXPECT_HAS(refusal("open.stl", ascii_stl(surface)), "has 1 triangle(s) where a closed surface has two");
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
