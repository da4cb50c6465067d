// SPDX-License-Identifier: Apache-2.0
// Loading of a scene with its volume and references.
#include "io/scene/load_input.h"

#include <algorithm>

#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

class LoadInput : public test::FolderTest {
 protected:
  LoadInput() {
    VolumeGeometry grid;
    grid.size = {8, 8, 8};
    Volume image(grid, VoxelType::Int16), truth(grid, VoxelType::UInt8);
    image.voxels<std::int16_t>()[3] = 7;
    truth.voxels<std::uint8_t>()[3] = 1;
    write_volume(folder / "image.nii", image);
    write_volume(folder / "truth.nii", truth);
    grid.size = {4, 4, 4};
    write_volume(folder / "other.nii", Volume(grid, VoxelType::UInt8));
  }
  fs::path scene_with(const std::string& reference) {
    return write("scene.json", R"({"simplexseg_scene": 1, "volume": "image.nii", "meshes": [{"name": "ball", )"
                               R"("sphere": {"centre_mm": [4, 4, 4], "radius_mm": 2}, "reference": {"labels": ")" +
                                   reference + R"("}}]})");
  }
  static constexpr LoadOptions::Voxels kSkip = LoadOptions::Voxels::Skip;
  static constexpr LoadOptions::BadReference kWarn = LoadOptions::BadReference::Warn;
};

TEST_F(LoadInput, ASceneIsLoadedWithItsVolumeAndReferences) {
  const LoadedInput input = load_scene(scene_with("truth.nii"));
  ASSERT_EQ(input.scene.meshes.size(), 1u);
  EXPECT_EQ(input.volume.voxels<std::int16_t>()[3], 7);
  EXPECT_EQ(input.volume_path, folder / "image.nii");
  ASSERT_TRUE(input.references.mask_for(input.scene.meshes[0]).has_value());
  EXPECT_TRUE(input.references.mask_for(input.scene.meshes[0])->voxels[3]);
  EXPECT_TRUE(load_input(folder / "scene.json").references.has(input.scene.meshes[0])) << "opened by a user";
}

TEST_F(LoadInput, ABadReferenceIsAnErrorOrAWarningWithTheSameText) {
  for (const char* reference : {"none.nii", "other.nii"}) {
    const fs::path scene = scene_with(reference);
    const std::string message = test::error_of([&] { load_scene(scene); });
    EXPECT_HAS(message, reference);
    for (const LoadedInput& input : {load_scene(scene, {.bad_reference = kWarn}), load_input(scene)}) {
      ASSERT_FALSE(input.warnings.empty());
      EXPECT_EQ(input.warnings.back(), message);
      EXPECT_FALSE(input.volume.empty());
      EXPECT_FALSE(input.references.has(input.scene.meshes[0]));
    }
  }
}

TEST_F(LoadInput, AReferenceOnAnotherGridIsResampledWithAWarning) {
  VolumeGeometry grid;
  grid.size = {4, 16, 16};
  grid.spacing_mm = {2, 0.5, 0.5};
  grid.origin_mm = {0.5, -0.1, -0.1};
  Volume fine(grid, VoxelType::UInt8);
  fine.voxels<std::uint8_t>()[1 + 4 * (6 + 16 * 8)] = 1;  // contains the centres of (2, 3, 4) and (3, 3, 4)
  fine.voxels<std::uint8_t>()[1 + 4 * (7 + 16 * 8)] = 1;  // contains no centre
  write_volume(folder / "fine.nii", fine);
  const LoadedInput input = load_scene(scene_with("fine.nii"));
  ASSERT_EQ(input.warnings.size(), 1u);
  EXPECT_HAS(input.warnings[0], "fine.nii");
  EXPECT_HAS(input.warnings[0], "another grid than the volume");
  const Mask mask = *input.references.mask_for(input.scene.meshes[0]);
  EXPECT_EQ(mask.geometry.size[0], 8);
  EXPECT_EQ(std::count(mask.voxels.begin(), mask.voxels.end(), 1), 2);
  EXPECT_TRUE(mask.voxels[2 + 8 * (3 + 8 * 4)] && mask.voxels[3 + 8 * (3 + 8 * 4)]);
}

TEST_F(LoadInput, SettingsAreAppliedBeforeOtherFilesAreRead) {
  const fs::path scene = scene_with("truth.nii");
  EXPECT_EQ(load_scene(scene, {.settings = {"simulation.damping=0.25"}}).scene.simulation.damping, 0.25f);
  fs::remove(folder / "truth.nii");
  EXPECT_HAS(test::error_of([&] { load_scene(scene, {.settings = {"simulation.dumping=1"}}); }), "damping");
}

TEST_F(LoadInput, VoxelsAndReferencesCanBeSkipped) {
  const fs::path scene = scene_with("none.nii");
  const LoadedInput input = load_scene(scene, {.voxels = kSkip});
  EXPECT_EQ(input.volume.type(), VoxelType::Int16);
  EXPECT_EQ(input.volume.geometry().size[0], 8);
  EXPECT_EQ(input.volume.range().max, 0);
}

TEST_F(LoadInput, AVolumeIsLoadedAsASceneWithoutMeshes) {
  const LoadedInput input = load_input(folder / "image.nii");
  EXPECT_TRUE(input.scene.meshes.empty());
  EXPECT_EQ(input.scene.volume_path, (folder / "image.nii").string());
  EXPECT_EQ(input.volume_path, folder / "image.nii");
  EXPECT_EQ(input.volume.voxels<std::int16_t>()[3], 7);
  EXPECT_GT(input.scene.simulation.start_vertices, 0);
  EXPECT_HAS(test::error_of([&] { load_scene(folder / "image.nii"); }), "image.nii");
}

}  // namespace
}  // namespace simplexseg
