// SPDX-License-Identifier: Apache-2.0
// Outputs and labels that cannot be written are refused before the volume is read, with exit status 2.
#include <algorithm>

#include "cli_fixture.h"
#include "core/error.h"
#include "io/platform/data_path.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

class Outputs : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
    write("broken.nii", "no image");  // reading it fails, so that a message about an output precedes the reading
    nlohmann::json scene = scene_json();
    scene["volume"] = "broken.nii";
    write_scene("broken.json", scene);
    fs::create_directory(folder_ / "folder");
  }
  void refuse(const Arguments& arguments, const std::string& why) const {
    std::string line;
    for (const std::string& argument : arguments) line += argument + " ";
    SCOPED_TRACE(line);
    const Outcome outcome = call(arguments);
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_EQ(outcome.out, "");
  }
  /// Writes a volume of 6^3 voxels of 5 mm, with a cube of one label.
  std::string labels(const std::string& name, double label, VoxelType type = VoxelType::Int32) const {
    VolumeGeometry grid;
    grid.size = {6, 6, 6};
    grid.spacing_mm.setConstant(5);
    Volume volume(grid, type);
    visit_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      const std::span<T> voxels = volume.voxels<T>();
      for (int k = 1; k < 5; ++k)
        for (int j = 1; j < 5; ++j)
          for (int i = 1; i < 5; ++i) voxels[volume.offset(i, j, k)] = static_cast<T>(label);
    });
    write_volume(path(name), volume);
    return path(name);
  }
  std::string report_of(const std::string& name) const {
    try {
      return find_data("reports/" + name, fs::path(SIMPLEXSEG_SOURCE_DIR) / "../shared/data").string();
    } catch (const Error&) {
      return "";
    }
  }
};

TEST_F(Outputs, OfARunAreCheckedBeforeTheVolumeIsRead) {
  const Arguments run{"run", path("broken.json")};
  const Arguments segment{"segment", path("broken.nii"), "--seed", "0,0,0"};
  for (const Arguments& command : {run, segment}) {
    const auto with = [&](const Arguments& more) {
      Arguments all = command;
      all.insert(all.end(), more.begin(), more.end());
      return all;
    };
    refuse(with({}), "broken.nii");
    for (const char* option : {"--labels", "--report", "--picture", "--save"}) {
      const std::string name = option == std::string("--labels")    ? "a.nii"
                               : option == std::string("--picture") ? "a.png"
                                                                    : "a.json";
      refuse(with({option, path("none/" + name)}), "the folder");
      refuse(with({option, path(std::string(300, 'n') + name)}), "choose another file name");
      refuse(with({option, ""}), "the value is empty");
    }
    refuse(with({"--labels", path("a.tif")}), "a.tif");
    refuse(with({"--labels", path("a.dcm")}), "broken.nii");
    refuse(with({"--picture", path("a.jpg")}), "a.jpg");
    refuse(with({"--save", path("a.txt")}), ".json");
    refuse(with({"--report", path("folder")}), "it is a folder");
    refuse(with({"--report", path("broken.nii")}), "it is an input of this command");
    refuse(with({"--report", path("a.json"), "--save", path("folder/../a.json")}), "two outputs have this name");
    refuse(with({"--report", path("m"), "--meshes", path("m")}), "two outputs have this name");
    refuse(with({"--meshes", path("broken.nii")}), "a file has this name");
    refuse(with({"--backend", "cuda", "--threads", "2"}), "--threads");
  }
  refuse({"run", path("broken.json"), "--report", path("truth.nii.gz")}, "it is an input of this command");
  fs::create_directory(folder_ / "folder/ball.ply");
  refuse({"run", path("broken.json"), "--meshes", path("folder")}, "it is a folder");
  refuse({"run", path("scene.json"), "--labels", path("a.rtstruct.dcm")}, "must refer to DICOM images");
  EXPECT_FALSE(exists("a.json"));
  EXPECT_FALSE(exists("m"));
}

TEST_F(Outputs, OfSeveralScenesAreCheckedBeforeAnyRun) {
  const std::string other = write_scene("other.json", scene_json());
  const Arguments run{"run", path("scene.json"), other};
  const auto with = [&](const Arguments& more) {
    Arguments all = run;
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  refuse(with({"--labels", path("none/{name}.nii.gz")}), "the folder");
  refuse(with({"--labels", path("{name}.tif")}), "tif");
  refuse(with({"--save", path("{name}.json")}), "it is an input of this command");
  refuse(with({"--labels", path("{name}.nii"), "--report", path("{name}.nii")}), "two outputs have this name");
  EXPECT_FALSE(exists("scene.nii"));
}

TEST_F(Outputs, OfOtherCommandsAreCheckedBeforeTheyRead) {
  const std::string broken = path("broken.nii"), none = path("none/a");
  refuse({"mesh", broken, none + ".ply"}, "the folder");
  refuse({"mesh", broken, path("a.ply"), path("a.ply")}, "two outputs have this name");
  refuse({"phantom", "sphere", path("a.nii"), "--labels", none + ".nii"}, "the folder");
  refuse({"phantom", "sphere", path("a.nii"), "--labels", path("a.txt")}, "a.txt");
  refuse({"phantom", "sphere", path("a.nii"), "--labels", path("a.nii")}, "two outputs have this name");
  refuse({"phantom", "label-image", path("truth.nii.gz"), path("truth.nii.gz")}, "it is an input of this command");
  EXPECT_FALSE(exists("a.nii"));
  for (const char* option : {"--json", "--csv"}) refuse({"clicks", broken, broken, option, none}, "the folder");
  refuse({"clicks", broken, broken, "--pictures", broken}, "a file has this name");
  refuse({"clicks", broken, broken, "--json", path("a"), "--csv", path("a")}, "two outputs have this name");
  refuse({"clicks", broken, broken, "--robot", "mesh", "--set", "simulation.dampin=1"}, "'damping'");
  refuse({"clicks", path("image.nii.gz"), path("truth.nii.gz"), "--label", "1", "--label", "9"},
         "no voxel has the label 9");
  refuse({"study", "error-time", path("broken.json"), "--out", broken}, "a file has this name");
  refuse({"study", "stability", "--out", broken}, "a file has this name");
  refuse({"study", "field-stability", "--out", broken}, "a file has this name");
  refuse({"archive", "get", "1.2.3", "--out", broken, "--server", "https://localhost:1"}, "exists already");
  refuse({"archive", "get", "1.2.3", "--out", broken + "/a", "--server", "https://localhost:1"}, "is a file");
  refuse({"archive", "get", "1.2.3", "1.2", "1.3", "--out", path("a"), "--server", "https://localhost:1"}, "only one");
}

TEST_F(Outputs, LabelsThatCannotBeWrittenAreRefusedAsAStart) {
  for (const double label : {70000., -2.}) {
    const std::string start = labels("start.nii", label);
    refuse({"segment", path("image.nii.gz"), path("a.nii"), "--labels-start", start}, std::to_string(int(label)));
  }
  if (const std::string file = report_of("lab_70000.nii.gz"); !file.empty())
    refuse({"segment", file, path("a.nii"), "--labels-start", file}, "70000");
  EXPECT_FALSE(exists("a.nii"));
}

/// A path that is not UTF-8 is read; the report replaces its invalid bytes. A scene cannot refer to it.
TEST_F(Outputs, PathsThatAreNotUtf8AreReported) {
  const std::string image = path("image\xff.nii.gz");
  fs::copy_file(path("image.nii.gz"), image);
  const Arguments segment{"segment", image, "--seed", "1,0,0", "--radius", "9", "--steps", "2"};
  Arguments reported = segment, saved = segment;
  reported.insert(reported.end(), {"--report", path("report\xff.json"), "--labels", path("labels\xff.nii")});
  const Outcome outcome = succeed(reported);
  EXPECT_NE(outcome.err.find("U+FFFD"), std::string::npos) << outcome.err;
  const nlohmann::json report = json_of("report\xff.json");
  EXPECT_EQ(report["volume"]["path"], path("image\xef\xbf\xbd.nii.gz"));
  EXPECT_NE(report["warnings"].back().get<std::string>().find("U+FFFD"), std::string::npos);
  EXPECT_TRUE(exists("labels\xff.nii"));
  saved.insert(saved.end(), {"--save", path("saved.json"), "--labels", path("never.nii")});
  refuse(saved, "not UTF-8");
  EXPECT_FALSE(exists("never.nii"));
  EXPECT_EQ(call({"info", image, "--json"}).status, 0);
  const Arguments clicks{"clicks", image, path("truth.nii.gz"), "--max", "0", "--json", path("clicks.json")};
  succeed(clicks);
  EXPECT_EQ(json_of("clicks.json")["image"], path("image\xef\xbf\xbd.nii.gz"));
}

// ---- labels of compare and mesh ----

class CompareLabels : public Outputs {
 protected:
  nlohmann::json compared(Arguments arguments) const {
    arguments.insert(arguments.begin(), "compare");
    arguments.push_back("--json");
    return nlohmann::json::parse(succeed(arguments).out);
  }
};

TEST_F(CompareLabels, TheTwoFilesMayUseTwoNumbers) {
  const std::string three = labels("three.nii", 3), one = labels("one.nii", 1);
  EXPECT_EQ(compared({one, three, "--label", "3", "--reference-label", "1"})["dice"], 1.0);
  EXPECT_EQ(compared({three, one, "--reference-label", "3"})["dice"], 1.0) << "the test without a number";
  EXPECT_EQ(compared({three, one, "--label", "1", "--reference-label", "all"})["dice"], 1.0);
  const Outcome missing = succeed({"compare", one, three, "--label", "3"});
  EXPECT_NE(missing.err.find("one.nii': no voxel has the label 3"), std::string::npos) << missing.err;
  refuse({"compare", one, three, "--label", "nan"}, "not a finite number");
  refuse({"compare", one, three, "--label", "Liver"}, "no label named 'Liver'");
}

TEST_F(CompareLabels, RoundedLabelsAreReadAndFractionsRefused) {
  const std::string whole = labels("whole.nii", 3), rounded = labels("rounded.nii", 3.0000458, VoxelType::Float32);
  const Outcome outcome = succeed({"compare", whole, rounded, "--label", "3"});
  EXPECT_NE(outcome.out.find("1.0000"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.err.find("rounded"), std::string::npos) << outcome.err;
  const std::string map = labels("map.nii", 0.7, VoxelType::Float32);
  refuse({"compare", whole, map}, "not labels");
  refuse({"compare", map, whole}, "--threshold");
  refuse({"mesh", map, path("a.ply")}, "not labels");
  EXPECT_EQ(compared({whole, map, "--threshold", "0.5"})["dice"], 1.0);
  EXPECT_EQ(compared({whole, map, "--label", "3", "--threshold", "0.5"})["dice"], 1.0);
  succeed({"mesh", map, path("a.ply"), "--threshold", "0.5"});
  refuse({"mesh", path("a.ply"), path("b.ply"), "--threshold", "0.5"}, "label volumes only");
}

TEST_F(CompareLabels, ReportedFilesOfRescaledLabels) {
  const std::string floats = report_of("lab_float.nii.gz"), whole = report_of("lab_int.nii.gz");
  if (floats.empty() || whole.empty()) GTEST_SKIP() << "no test data";
  EXPECT_EQ(compared({whole, floats, "--label", "3"})["dice"], 1.0);
  EXPECT_EQ(compared({floats, whole, "--label", "3"})["dice"], 1.0);
}

/// Voxels of 8 micrometres: no length or volume reads 0.00.
TEST_F(CompareLabels, SmallSizesKeepTheirDigits) {
  VolumeGeometry grid;
  grid.size = {12, 12, 12};
  grid.spacing_mm.setConstant(0.008);
  Volume volume(grid, VoxelType::UInt8);
  for (int k = 3; k < 9; ++k)
    for (int j = 3; j < 9; ++j)
      for (int i = 3; i < 9; ++i) volume.voxels<std::uint8_t>()[volume.offset(i, j, k)] = 1;
  write_volume(path("small.nii"), volume);
  EXPECT_NE(succeed({"compare", path("small.nii"), path("small.nii")}).out.find("0.000111"), std::string::npos);
  const std::string text = succeed({"mesh", path("small.nii"), path("small.ply")}).out;
  EXPECT_NE(text.find("µm³"), std::string::npos) << text;
  EXPECT_NE(text.find("µm on average"), std::string::npos) << text;
}

}  // namespace
}  // namespace simplexseg
