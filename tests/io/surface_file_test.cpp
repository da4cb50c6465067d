// SPDX-License-Identifier: Apache-2.0
// Files of several surfaces: 3MF and glTF.
#include "core/number_text.h"
#include "io/mesh/mesh_io.h"
#include "io/scene/scene_export.h"
#include "mesh/iso_surface.h"
#include "mesh/mesh_geometry.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::error_of;

class SurfaceFiles : public test::FolderTest {
 protected:
  /// Two spheres, one with a name that XML and JSON must escape.
  static Scene two_objects() {
    Scene scene;
    for (int n = 0; n < 2; ++n) {
      MeshItem& item = scene.meshes.emplace_back();
      item.id = static_cast<ItemId>(n + 1), item.label = n + 1;
      item.mesh = make_sphere({20.0 * n - 7, 30, -110.5}, 5 + n, 3);
    }
    scene.meshes[0].name = "Left kidney", scene.meshes[0].colour = {230, 160, 60};
    scene.meshes[1].name = "a <&> \"b\" \xc3\xa9", scene.meshes[1].colour = {1, 128, 255};
    return scene;
  }
  /// Output of the independent reader for a file.
  std::string read(const fs::path& file) const {
    const std::string command =
        "/usr/bin/python3 '" SIMPLEXSEG_SOURCE_DIR "/tests/io/surface_file_reader.py' '" + file.string() + "' 2>&1";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    std::string text;
    for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
    ::pclose(pipe);
    return text;
  }
  /// The lines that the reader prints for these objects, in mm of the patient.
  static std::string lines_for(const std::vector<NamedSurface>& surfaces) {
    std::string lines;
    for (const NamedSurface& surface : surfaces) {
      const TriangleMesh triangles = tessellate(*surface.mesh);
      Eigen::Vector3f low = triangles.positions.front(), high = low;
      double volume = 0;
      for (const Eigen::Vector3f& p : triangles.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
      for (const auto& t : triangles.triangles)
        volume += triangles.positions[t[0]].cast<double>().dot(
                      triangles.positions[t[1]].cast<double>().cross(triangles.positions[t[2]].cast<double>())) /
                  6;
      lines += surface.name + "|" + std::to_string(surface.colour.red) + " " + std::to_string(surface.colour.green) +
               " " + std::to_string(surface.colour.blue) + "|" + std::to_string(triangles.positions.size()) + " " +
               std::to_string(triangles.triangles.size()) + "|" + fixed_text(volume, 1) + "|";
      for (const Eigen::Vector3f& corner : {low, high})
        for (int a = 0; a < 3; ++a) lines += (a || corner == high ? " " : "") + fixed_text(double(corner[a]), 2);
      lines += "\n";
    }
    return lines;
  }
};

TEST_F(SurfaceFiles, AnIndependentReaderFindsUnitsNamesColoursAndShapes) {
  const Scene scene = two_objects();
  const std::vector<NamedSurface> surfaces{{scene.meshes[0].name, scene.meshes[0].colour, &scene.meshes[0].mesh},
                                           {scene.meshes[1].name, scene.meshes[1].colour, &scene.meshes[1].mesh}};
  save_surfaces(folder / "case.glb", scene);
  EXPECT_EQ(read(folder / "case.glb"), "metre, normals point outwards\n" + lines_for(surfaces));
  save_meshes(folder, scene, ".glb");
  EXPECT_EQ(read(folder / "Left kidney.glb"), "metre, normals point outwards\n" + lines_for({surfaces[0]}));
  try {
    require_mesh_name("case.3mf");
  } catch (const Error& built_without_library) {
    GTEST_SKIP() << built_without_library.what();
  }
  save_surfaces(folder / "case.3mf", scene);
  EXPECT_EQ(read(folder / "case.3mf"), "millimeter\n" + lines_for(surfaces));
  write_mesh(folder / "one.3mf", scene.meshes[1].mesh);
  EXPECT_EQ(read(folder / "one.3mf"), "millimeter\n" + lines_for({{"one", {230, 160, 60}, surfaces[1].mesh}}));
}

TEST_F(SurfaceFiles, BadInputIsReportedWithoutAFile) {
  const SimplexMesh empty;
  const NamedSurface none{"none", {}, &empty};
  EXPECT_NE(error_of([&] { write_surfaces(folder / "a.glb", {}); }).find("there is none"), std::string::npos);
  EXPECT_NE(error_of([&] {
              write_surfaces(folder / "a.glb", {&none, 1});
            }).find("empty or incomplete"),
            std::string::npos);
  EXPECT_NE(error_of([&] { write_surfaces(folder / "a.ply", {&none, 1}); }).find("holds one mesh"), std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder));
  EXPECT_FALSE(is_mesh_name("a.glb")) << "these files are not read";
  EXPECT_TRUE(holds_several_surfaces("A.GLB"));
  EXPECT_FALSE(holds_several_surfaces(""));
}

}  // namespace
}  // namespace simplexseg
