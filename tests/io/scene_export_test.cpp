// SPDX-License-Identifier: Apache-2.0
// Export of labels and meshes of a scene, and the names of the files.
#include "io/scene/scene_export.h"

#include <set>

#include "image/volume.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/file_names.h"
#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

Names distinct(const Names& names) { return distinct_file_names(names, "mesh"); }

TEST(FileNames, OrdinaryNamesAreUnchanged) {
  const Names names{"brain", "left kidney", "Ångström", "肝臓", "a.b", "x-2", "(old) v1_final"};
  EXPECT_EQ(distinct(names), names);
}

TEST(FileNames, InvalidCharactersAreReplaced) {
  EXPECT_EQ(distinct({"a/b"}), Names{"a_b"});
  EXPECT_EQ(distinct({"../../etc/passwd"}), Names{"_._.._etc_passwd"});
  EXPECT_EQ(distinct({"a\\b:c*d?e\"f<g>h|i"}), Names{"a_b_c_d_e_f_g_h_i"});
  EXPECT_EQ(distinct({std::string("a\n\t\0\x7f", 5)}), Names{"a____"});
  EXPECT_EQ(distinct({"  two   blanks  "}), Names{"two blanks"});
  EXPECT_EQ(distinct({"."}), Names{"_"});
  EXPECT_EQ(distinct({"end."}), Names{"end_"});
  EXPECT_EQ(distinct({"bad \xff\xc3 utf-8 \xed\xa0\x80"}), Names{"bad __ utf-8 ___"});
}

TEST(FileNames, AnEmptyNameIsReplaced) {
  EXPECT_EQ(distinct({""}), Names{"mesh"});
  EXPECT_EQ(distinct({"", "  ", "mesh"}), (Names{"mesh", "mesh-2", "mesh-3"}));
}

TEST(FileNames, EqualNamesAfterReplacementOrIgnoringCaseGetNumbers) {
  EXPECT_EQ(distinct({"a/b", "a_b", "A_b"}), (Names{"a_b", "a_b-2", "A_b-3"}));
  EXPECT_EQ(distinct({"Ärger", "ärger", "ÄRGER"}), (Names{"Ärger", "ärger-2", "ÄRGER-3"}));
  EXPECT_EQ(distinct({"a", "a-2", "A", "a-2"}), (Names{"a", "a-2", "A-3", "a-2-2"}));
}

TEST(FileNames, LongNamesAreCutBetweenCharactersAndNumbered) {
  std::string umlauts = "x";
  for (int n = 0; n < 400; ++n) umlauts += "ä";
  const std::string letters(5000, 'm');
  const Names names = distinct({letters, letters + "1", umlauts});
  for (const std::string& name : names) {
    EXPECT_GT(name.size(), 100u);
    EXPECT_LT(name.size(), 140u);
  }
  EXPECT_EQ(names[1], names[0] + "-2");
  EXPECT_EQ(names[2].size() % 2, 1u) << "the last ä is whole";
  EXPECT_EQ(distinct({names[2]}), Names{names[2]});
}

TEST(FileNames, AddingNamesDoesNotChangeEarlierOnes) {
  const Names all{"a/b", "b", "a_b", "A_B", "", "b-2", "B", "a:b", "mesh", "b"};
  const Names whole = distinct(all);
  EXPECT_EQ(std::set<std::string>(whole.begin(), whole.end()).size(), all.size());
  for (std::size_t n = 0; n <= all.size(); ++n)
    EXPECT_EQ(distinct(Names(all.begin(), all.begin() + n)), Names(whole.begin(), whole.begin() + n)) << n;
}

class SceneExport : public test::FolderTest {
 protected:
  static MeshItem ball(const std::string& name, const Eigen::Vector3d& centre_mm, int label = 1) {
    MeshItem item;
    item.name = name;
    item.label = label;
    item.mesh = make_sphere(centre_mm, 6, 1);
    return item;
  }
};

TEST_F(SceneExport, EachMeshIsWrittenToASeparateFile) {
  Scene scene;
  Names names{"a/b", "a_b", "A_b", "", std::string(5000, 'm'), "肝臓"};
  for (const std::string& name : names) scene.meshes.push_back(ball(name, {double(scene.meshes.size()), 0, 0}));
  const std::vector<fs::path> files = save_meshes(folder, scene);
  ASSERT_EQ(files.size(), names.size());
  EXPECT_EQ(files[0], folder / "a_b.ply");
  EXPECT_EQ(files[5], folder / "肝臓.ply");
  std::set<fs::path> there;
  for (const auto& entry : fs::directory_iterator(folder)) there.insert(entry.path());
  EXPECT_EQ(there, std::set<fs::path>(files.begin(), files.end())) << "no other files, and none outside the folder";
  for (std::size_t k = 0; k < files.size(); ++k)
    EXPECT_EQ(read_mesh(files[k]).positions, scene.meshes[k].mesh.positions) << files[k];
  EXPECT_EQ(save_meshes(folder, scene), files) << "saved again: the same files";
}

TEST_F(SceneExport, MeshesAreWrittenInTheRequestedFormat) {
  Scene scene;
  scene.meshes.push_back(ball("a", {0, 0, 0}));
  for (const char* extension : {".obj", ".stl", ".vtk", ".vtp"}) {
    const std::vector<fs::path> files = save_meshes(folder, scene, extension);
    ASSERT_EQ(files, std::vector<fs::path>{folder / (std::string("a") + extension)});
    EXPECT_NO_THROW(read_mesh(files[0]));
  }
}

TEST_F(SceneExport, AFolderThatDoesNotExistIsAnError) {
  Scene scene;
  scene.meshes.push_back(ball("a", {0, 0, 0}));
  EXPECT_HAS(test::error_of([&] { save_meshes(folder / "none", scene); }), "none");
}

TEST_F(SceneExport, OverlappingMeshesAreReported) {
  VolumeGeometry grid;
  grid.size = {24, 16, 16};
  grid.origin_mm = {-8, -8, -8};
  Scene scene;
  scene.meshes = {ball("one", {0, 0, 0}, 2), ball("two", {8, 0, 0}, 3)};
  EXPECT_HAS(save_labels(folder / "labels.nii.gz", scene, grid), "voxels lie inside two or more segmentations");
  const Volume labels = read_volume(folder / "labels.nii.gz");
  EXPECT_TRUE(labels.geometry().same_grid(grid));
  EXPECT_EQ(labels.sample({0, 0, 0}), 2);
  EXPECT_EQ(labels.sample({4, 0, 0}), 2) << "in both meshes: assigned to the first";
  EXPECT_EQ(labels.sample({8, 0, 0}), 3);
  scene.meshes.pop_back();
  EXPECT_EQ(save_labels(folder / "labels.nii.gz", scene, grid), "");
  EXPECT_EQ(read_volume(folder / "labels.nii.gz").sample({8, 0, 0}), 0);
  EXPECT_HAS(test::error_of([&] { save_labels(folder / "labels.txt", scene, grid); }), ".txt");
}

TEST_F(SceneExport, SegmentationsHaveTheNamesAndColoursOfTheirMeshes) {
  VolumeGeometry grid;
  grid.size = {24, 16, 16};
  grid.origin_mm = {-8, -8, -8};
  Scene scene;
  scene.meshes = {ball("liver: left", {0, 0, 0}, 5), ball("", {8, 0, 0}, 3), ball("more", {0, 0, 0}, 5)};
  scene.meshes[0].colour = {1, 128, 255};
  save_labels(folder / "labels.seg.nrrd", scene, grid);
  const LoadedVolume loaded = load_volume(folder / "labels.seg.nrrd");
  EXPECT_EQ(loaded.volume.sample({0, 0, 0}), 5);
  ASSERT_EQ(loaded.segments.size(), 2u);
  EXPECT_EQ(loaded.segments[0], (SegmentName{5, "liver: left, more", {1, 128, 255}, tissue_code()}));
  EXPECT_EQ(loaded.segments[1].name, "Segment_3");
}

}  // namespace
}  // namespace simplexseg
