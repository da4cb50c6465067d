// SPDX-License-Identifier: Apache-2.0
// Checks of output files and folders before the work.
#include "io/platform/output_checks.h"

#include "io/scene/json_input.h"
#include "io/scene/scene_export.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::error_of;

class OutputCheck : public test::FolderTest {
 protected:
  std::string refusal(const fs::path& output, std::vector<fs::path> inputs = {}) {
    OutputChecks checks(std::move(inputs));
    return error_of([&] { checks.require_file(output); });
  }
  /// Writes the start of a DICOM file (PS3.10) with a SOP class.
  fs::path dicom(const std::string& name, const std::string& sop_class) {
    std::string bytes(128, '\0');
    bytes += "DICM";
    bytes += std::string("\x02\0\x02\0UI", 6) + static_cast<char>(sop_class.size()) + '\0' + sop_class;
    return write(name, bytes + std::string(200, '\0'));
  }
};

TEST_F(OutputCheck, AFileThatCanBeWrittenPassesAndIsNotCreated) {
  OutputChecks checks({folder / "image.nii"});
  checks.require_file(folder / "new.nii");
  EXPECT_TRUE(fs::is_empty(folder));
  write("old.nii", "old");
  checks.require_file(folder / "old.nii");
  EXPECT_EQ(test::bytes_of(folder / "old.nii"), "old");
}

TEST_F(OutputCheck, PlacesWithoutWriteAccessAreRefused) {
  fs::create_directory(folder / "sub");
  EXPECT_HAS(refusal(folder / "none/a.nii"), "does not exist");
  EXPECT_HAS(refusal(folder / "sub"), "it is a folder");
  EXPECT_HAS(refusal("/dev/null"), "device");
  EXPECT_HAS(refusal(folder / (std::string(300, 'n') + ".nii")), "choose another file name");
  EXPECT_HAS(error_of([&] { require_writable_folder(folder / std::string(300, 'n')); }), "choose another file name");
  const fs::path file = write("file", "x");
  EXPECT_HAS(error_of([&] { require_writable_folder(file); }), "a file has this name");
  EXPECT_HAS(error_of([&] { require_writable_folder(file / "below"); }), "is a file");
  EXPECT_HAS(error_of([&] { make_folder(file / "below"); }), "cannot create the folder");
  require_writable_folder(folder / "a/b/c");
  EXPECT_FALSE(fs::exists(folder / "a")) << "checked only";
  make_folder(folder / "a/b/c");
  EXPECT_TRUE(fs::is_directory(folder / "a/b/c"));
}

TEST_F(OutputCheck, InputsAreNotReplaced) {
  const fs::path image = write("image.nii", "x");
  fs::create_symlink(image, folder / "link.nii");
  EXPECT_HAS(refusal(image, {image}), "it is an input of this command");
  EXPECT_HAS(refusal(folder / "link.nii", {image}), "it is an input of this command");
  write("scan.mhd", "NDims = 3\nElementDataFile = scan.zraw\n"), write("scan.zraw", "x"), write("other.zraw", "x");
  EXPECT_HAS(refusal(folder / "scan.zraw", {folder / "scan.mhd"}), "voxels of the input");
  write("a.hdr", "x"), write("a.img", "x");
  EXPECT_HAS(refusal(folder / "a.img", {folder / "a.hdr"}), "voxels of the input");
  OutputChecks(std::vector<fs::path>{folder / "scan.mhd"}).require_file(folder / "other.zraw");
}

TEST_F(OutputCheck, ImagesInAnInputFolderAreNotReplaced) {
  fs::create_directory(folder / "series");
  EXPECT_HAS(refusal(dicom("series/slice1.dcm", "1.2.840.10008.5.1.4.1.1.2"), {folder / "series"}),
             "image in the input");
  EXPECT_HAS(refusal(dicom("series/IM0001", "1.2.840.10008.5.1.4.1.1.4"), {folder}), "image in the input");
  EXPECT_HAS(refusal(dicom("series/x.dcm", "1.2.840.10008.5.1.4.1.1.7.1"), {folder}), "image in the input");
  EXPECT_HAS(refusal(write("series/no_preamble.dcm", "x"), {folder}), "image in the input");
  OutputChecks checks({folder / "series"});
  for (const char* result : {"1.2.840.10008.5.1.4.1.1.66.4", "1.2.840.10008.5.1.4.1.1.481.3"})
    checks.require_file(dicom(std::string("series/") + result, result));  // written by an earlier run
  checks.require_file(write("series/labels.nii.gz", "x"));
}

TEST_F(OutputCheck, TwoOutputsNeedTwoNames) {
  OutputChecks checks{std::vector<fs::path>()};
  checks.require_file(folder / "a.nii");
  fs::create_directory(folder / "sub");
  EXPECT_HAS(error_of([&] { checks.require_file(folder / "sub/../a.nii"); }), "two outputs have this name");
  EXPECT_HAS(error_of([&] { checks.require_folder(folder / "a.nii"); }), "two outputs have this name");
}

TEST_F(OutputCheck, LabelsThatCannotBeWrittenAreRefusedByTheScene) {
  Scene scene;
  EXPECT_HAS(error_of([&] { require_labels_name(folder / "a.rtstruct.dcm", scene); }), "no segmentation");
  EXPECT_HAS(error_of([&] { require_labels_name(folder / "a.dcm", scene); }), "no segmentation");
  scene.meshes.emplace_back().name = "a";
  for (const int label : {0, -2, 65536, 70000}) {
    scene.meshes[0].label = label;
    EXPECT_HAS(error_of([&] { require_labels_name(folder / "a.nii.gz", scene); }), std::to_string(label));
  }
  scene.meshes[0].label = 65535;
  require_labels_name(folder / "a.nii.gz", scene);
  scene.volume_path = "/data/\xff.nii";
  EXPECT_HAS(error_of([&] { require_scene_name(folder / "a.json", scene); }), "not UTF-8");
  scene.volume_path.clear();
  require_scene_name(folder / "a.json", scene);
  EXPECT_HAS(error_of([&] { require_scene_name(folder / "\xff.json", scene); }), "not UTF-8");
  EXPECT_HAS(error_of([&] { require_scene_name(folder / "a.txt", scene); }), ".json");
}

TEST(JsonInput, ElementsThatDoNotExistAreErrors) {
  const JsonInput input = JsonInput::of_text(R"({"list": [1, 2], "text": "x"})", "a.json", "scene");
  EXPECT_EQ(input["list"][1].number(), 2);
  EXPECT_HAS(error_of([&] { input["list"][2]; }), "a.json: list: it has 2 values");
  EXPECT_HAS(error_of([&] { input["list"][-1]; }), "it has 2 values");
  EXPECT_HAS(error_of([&] { input["text"][0]; }), "type string");
  EXPECT_HAS(error_of([&] { input[0]; }), "type object");
}

}  // namespace
}  // namespace simplexseg
