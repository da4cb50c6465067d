// SPDX-License-Identifier: Apache-2.0
// Autosave and recovery; presets; checksums of volumes.
#include "io/scene/recovery.h"

#include <cstring>
#include <fstream>

#include "io/scene/load_input.h"
#include "io/scene/preset_io.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"
#include "scene_files.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

class Recovery : public SceneIo {
 protected:
  fs::path root() const { return folder_ / "work"; }
  Scene scene() {
    Scene scene = any_scene();
    scene.volume_path.clear();
    return scene;
  }
  std::vector<std::string> remaining_files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(root())) names.push_back(entry.path().filename());
    return names;
  }
};

TEST_F(Recovery, AnAutosaveIsFoundOnlyAfterItsProgramHasEnded) {
  const Scene saved = scene();
  const fs::path folder = [&] {
    AutosaveStore store(root()), idle(root());
    store.save(saved, {"/data/ct.nii.gz", "/data/ct.json", 1700000000});
    store.save(saved, {"/data/ct.nii.gz", "", 1700000100});
    EXPECT_TRUE(find_recoverable_work(root()).empty()) << "both are still running";
    fs::copy(store.folder(), root() / "window-killed", fs::copy_options::recursive);
    return root() / "window-killed";
  }();
  EXPECT_FALSE(remaining_files().empty());
  {
    std::vector<RecoverableWork> lost = find_recoverable_work(root());
    ASSERT_EQ(lost.size(), 1u) << "programs that end normally leave nothing";
    EXPECT_EQ(lost[0].info.opened, "/data/ct.nii.gz");
    EXPECT_EQ(lost[0].info.scene_file, "");
    EXPECT_EQ(lost[0].info.saved_at_s, 1700000100);
    EXPECT_EQ(lost[0].info.meshes, 2);
    EXPECT_EQ(lost[0].info.points, 8);
    EXPECT_TRUE(find_recoverable_work(root()).empty()) << "it is locked by one window";
    const Scene back = read_scene(lost[0].scene).scene;
    ASSERT_EQ(back.meshes.size(), saved.meshes.size());
    EXPECT_EQ(back.meshes[0].mesh.positions, saved.meshes[0].mesh.positions);
  }
  std::vector<RecoverableWork> lost = find_recoverable_work(root());
  ASSERT_EQ(lost.size(), 1u) << "not restored: offered again";
  lost[0].folder.remove();
  EXPECT_FALSE(fs::exists(folder));
  EXPECT_TRUE(remaining_files().empty());
}

TEST_F(Recovery, AFailedAutosaveKeepsThePreviousOne) {
  AutosaveStore store(root());
  store.save(scene(), {"a.nii", "", 1});
  Scene bad = scene();
  bad.meshes[1].name = bad.meshes[0].name;
  EXPECT_THROW(store.save(bad, {"b.nii", "", 2}), Error);
  fs::copy(store.folder(), root() / "window-killed", fs::copy_options::recursive);
  const std::vector<RecoverableWork> lost = find_recoverable_work(root());
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0].info.opened, "a.nii");
  EXPECT_NO_THROW(read_scene(lost[0].scene));
  store.discard();
  EXPECT_FALSE(fs::exists(store.folder() / "work.json"));
}

TEST_F(Recovery, DamagedFoldersAreIgnored) {
  fs::create_directories(root() / "window-bad");
  fs::create_directories(root() / "window-gone");
  fs::create_directories(root() / "something else");
  std::ofstream(root() / "window-bad" / "work.json") << "{ \"simplexseg_work\": 1, ";
  std::ofstream(root() / "window-gone" / "work.json")
      << R"({"simplexseg_work": 1, "kept": 4, "opened": "a", "scene_file": "", "saved_at_s": 1, "meshes": 1,
            "points": 0, "vertices": 20})";
  EXPECT_TRUE(find_recoverable_work(root()).empty());
  EXPECT_TRUE(fs::exists(root() / "window-bad" / "work.json"));
  EXPECT_TRUE(fs::exists(root() / "something else"));
  EXPECT_TRUE(find_recoverable_work(folder_ / "nowhere").empty());
}

TEST_F(Recovery, AChangedVolumeIsAWarning) {
  VolumeGeometry grid;
  grid.size = {9, 8, 7};
  Volume volume(grid, VoxelType::Int16);
  volume.voxels<std::int16_t>()[100] = 40;
  write_volume(folder_ / "image.nii", volume);
  LoadedInput opened = load_input(folder_ / "image.nii");
  EXPECT_FALSE(opened.scene.volume_checksum.empty());
  opened.scene.view = SavedView{{1, 2, 3}, 400, 40.5, ""};
  write_scene(folder_ / "scene.json", opened.scene);
  const LoadedInput same = load_input(folder_ / "scene.json");
  EXPECT_TRUE(same.warnings.empty());
  EXPECT_EQ(same.scene.volume_checksum, opened.scene.volume_checksum);
  ASSERT_TRUE(same.scene.view);
  EXPECT_EQ(same.scene.view->crosshair_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(same.scene.view->level, 40.5);
  write_volume(folder_ / "image.nrrd", volume);
  EXPECT_EQ(load_input(folder_ / "image.nrrd").scene.volume_checksum, opened.scene.volume_checksum)
      << "the same voxels in another format";
  volume.voxels<std::int16_t>()[101] = 1;
  EXPECT_NE(checksum_of(volume), opened.scene.volume_checksum);
  write_volume(folder_ / "image.nii", volume);
  const LoadedInput changed = load_input(folder_ / "scene.json");
  ASSERT_EQ(changed.warnings.size(), 1u);
  EXPECT_NE(changed.warnings[0].find("is not the image with which the scene was saved"), std::string::npos);
  grid.spacing_mm.x() = 1.5;
  EXPECT_NE(checksum_of(Volume(grid, VoxelType::Int16)), checksum_of(Volume({grid.size}, VoxelType::Int16)));
}

TEST_F(Recovery, APresetIsRestoredBitForBit) {
  std::mt19937 random(5);
  Preset preset{any_forces(random), default_simulation_parameters()};
  preset.simulation->damping = 1.0f / 3;
  write_preset(folder_ / "a.preset.json", preset);
  const Preset back = read_preset(folder_ / "a.preset.json");
  EXPECT_EQ(std::memcmp(&back.forces, &preset.forces, sizeof preset.forces), 0);
  ASSERT_TRUE(back.simulation);
  EXPECT_EQ(std::memcmp(&*back.simulation, &*preset.simulation, sizeof *preset.simulation), 0);
  std::ofstream(folder_ / "b.json") << R"({"simplexseg_preset": 1, "forces": {"smoothing": {"weight": 1e9}}})";
  EXPECT_THROW(read_preset(folder_ / "b.json"), Error);
  std::ofstream(folder_ / "c.json") << R"({"simplexseg_scene": 1})";
  EXPECT_THROW(read_preset(folder_ / "c.json"), Error);
  std::ofstream(folder_ / "d.json") << R"({"simplexseg_preset": 1, "force": {}})";
  EXPECT_THROW(read_preset(folder_ / "d.json"), Error);
}

}  // namespace
}  // namespace simplexseg
