// SPDX-License-Identifier: Apache-2.0
// Meshes from labels: the subcommand, and scenes whose meshes start from labels.
#include "cli_fixture.h"
#include "io/mesh/mesh_io.h"
#include "io/volume/volume_io.h"
#include "mesh/mesh_geometry.h"

namespace simplexseg {
namespace {

class MeshCommand : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
  }
};

TEST_F(MeshCommand, WritesTheMeshInEachRequestedFormat) {
  const Outcome done = succeed({"mesh", path("truth.nii.gz"), path("a.ply"), path("a.stl"), path("a.vtp")});
  EXPECT_NE(done.out.find("parts     1 ("), std::string::npos) << done.out;
  EXPECT_NE(done.out.find("surfaces  1, genus 0"), std::string::npos) << done.out;
  const SimplexMesh mesh = read_mesh(path("a.ply"));
  const double radius_mm = 0.3 * 24 * 2;  // sphere of the truth
  EXPECT_NEAR(measure(mesh).volume_mm3, 4.0 / 3 * M_PI * std::pow(radius_mm, 3), 300);
  EXPECT_TRUE(exists("a.stl") && exists("a.vtp"));
  succeed({"mesh", path("truth.nii.gz"), path("b.ply"), "--label", "1", "--part", "1", "--vertices", "300"});
  EXPECT_NEAR(read_mesh(path("b.ply")).vertex_count(), 300, 60);
}

TEST_F(MeshCommand, ALabelIsSelectedByTheNameInItsFile) {
  const Volume truth = read_volume(path("truth.nii.gz"));
  write_labels(path("named.seg.nrrd"), truth, {{1, "Left kidney", Colour{1, 2, 3}}});
  succeed({"mesh", path("named.seg.nrrd"), path("a.ply"), "--label", "left kidney"});
  succeed({"mesh", path("named.seg.nrrd"), path("b.ply"), "--label", "1"});
  EXPECT_EQ(read_mesh(path("a.ply")).positions, read_mesh(path("b.ply")).positions);
  const Outcome other = call({"mesh", path("named.seg.nrrd"), path("c.ply"), "--label", "spleen"});
  EXPECT_EQ(other.status, 2);
  EXPECT_NE(other.err.find("its labels are Left kidney"), std::string::npos) << other.err;
}

TEST_F(MeshCommand, ARunWritesMeshesInTheRequestedFormat) {
  succeed({"run", path("scene.json"), "--steps", "1", "--meshes", path("m"), "--mesh-format", "vtp"});
  EXPECT_TRUE(exists("m/ball.vtp"));
  EXPECT_FALSE(exists("m/ball.ply"));
  EXPECT_EQ(call({"run", path("scene.json"), "--steps", "1", "--meshes", path("m"), "--mesh-format", "x"}).status, 2);
}

TEST_F(MeshCommand, SurfacesOfOtherProgramsBecomeSimplexMeshes) {
  succeed({"mesh", path("truth.nii.gz"), path("a.stl")});
  const Outcome done = succeed({"mesh", path("a.stl"), path("b.ply")});
  EXPECT_NE(done.out.find("surfaces  1, genus 0"), std::string::npos) << done.out;
  EXPECT_GT(read_mesh(path("b.ply")).vertex_count(), 1000);
  EXPECT_EQ(call({"mesh", path("a.stl"), path("c.ply"), "--label", "1"}).status, 2);
  EXPECT_EQ(call({"mesh", path("a.stl"), path("a.stl")}).status, 2) << "the output is the input file";
}

TEST_F(MeshCommand, BadInputIsOneLine) {
  const auto rejection = [&](const Arguments& arguments, const std::string& why) {
    const Outcome outcome = call(arguments);
    EXPECT_EQ(outcome.status, 2);
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(exists("a.ply"));
  };
  rejection({"mesh", path("truth.nii.gz"), path("a.ply"), "--label", "9"}, "choose one of its labels: 1");
  rejection({"mesh", path("truth.nii.gz"), path("a.ply"), "--part", "2"}, "has 1 connected part;");
  rejection({"mesh", path("none.nii.gz"), path("a.ply")}, "no such file");
  rejection({"mesh", path("truth.nii.gz"), path("a.ply"), path("a.txt")}, ".txt");
  rejection({"mesh", path("truth.nii.gz"), path("no/a.ply")}, "no");
  rejection({"mesh", path("truth.nii.gz")}, "OUT");
}

TEST_F(MeshCommand, AMeshFromLabelsIsStableAndCorrectedByPoints) {
  nlohmann::json scene = scene_json();
  nlohmann::json& mesh = scene["meshes"][0];
  for (const char* key : {"sphere", "forces", "final_vertices"}) mesh.erase(key);
  mesh["start"] = {{"labels", "truth.nii.gz"}};
  scene.erase("forces");
  write_scene("start.json", scene);
  succeed({"run", path("start.json"), "--steps", "200", "--report", path("a.json"), "--meshes", path("a")});
  EXPECT_GT(json_of("a.json")["meshes"][0]["dice"].get<double>(), 0.97);
  const SimplexMesh before = read_mesh(path("a/ball.ply"));
  Eigen::Vector3f point = before.positions[0];
  for (const Eigen::Vector3f& p : before.positions)
    if (p[0] > point[0]) point = p;
  point[0] += 5;
  scene["points"] = {{{"mesh", "ball"}, {"position_mm", {point[0], point[1], point[2]}}, {"outward", {1, 0, 0}}}};
  write_scene("start.json", scene);
  succeed({"run", path("start.json"), "--steps", "600", "--meshes", path("b")});
  const SimplexMesh after = read_mesh(path("b/ball.ply"));
  float nearest = 1e9f, min_x = 0, min_x_before = 0;
  for (const Eigen::Vector3f& p : after.positions)
    nearest = std::min(nearest, (p - point).norm()), min_x = std::min(min_x, p[0]);
  for (const Eigen::Vector3f& p : before.positions) min_x_before = std::min(min_x_before, p[0]);
  EXPECT_LT(nearest, 1.5f) << "initial distance: 5 mm";
  EXPECT_NEAR(min_x, min_x_before, 0.5f) << "the opposite end does not move";
}

}  // namespace
}  // namespace simplexseg
