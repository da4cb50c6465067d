// SPDX-License-Identifier: Apache-2.0
// Invalid input of every kind: one line on stderr, exit status 2, no output, no crash, no file written.
#include <sys/resource.h>

#include <algorithm>
#include <functional>
#include <tuple>

#include "cli_fixture.h"
#include "core/error.h"
#include "io/platform/data_path.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

class BadInput : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
  }
  /// Runs the arguments in this process and in a separate process.
  void expect_rejected(const Arguments& arguments, const std::string& message) const {
    std::string line = "simplexseg-cli";
    for (const std::string& argument : arguments) line += " " + argument;
    SCOPED_TRACE(line);
    for (const Outcome& outcome : {call(arguments), call_program(arguments)}) {
      EXPECT_EQ(outcome.status, 2) << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
      EXPECT_EQ(outcome.err.rfind("simplexseg-cli: ", 0), 0u) << outcome.err;
      EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
      EXPECT_EQ(outcome.out, "");
    }
  }
  /// Uses the file as a volume of every subcommand that reads one; plan reads the header only.
  void expect_no_volume(const std::string& name, const std::string& message, bool header_suffices = true) const {
    expect_rejected({"info", path(name)}, message);
    expect_rejected({"compare", path(name), path("truth.nii.gz")}, message);
    expect_rejected({"compare", path("truth.nii.gz"), path(name)}, message);
    expect_rejected({"phantom", "label-image", path(name), path("out.nii")}, message);
    nlohmann::json scene = scene_json();
    scene["volume"] = name;
    expect_rejected({"run", write_scene("bad.json", scene), "--labels", path("out.nii")}, message);
    if (header_suffices) expect_rejected({"plan", path("bad.json")}, message);
    scene = scene_json();
    scene["meshes"][0]["reference"]["labels"] = name;
    expect_rejected({"run", write_scene("bad.json", scene), "--labels", path("out.nii")}, message);
    EXPECT_FALSE(exists("out.nii"));
  }
  void expect_no_scene(const std::string& scene, const std::string& message) const {
    expect_rejected({"run", scene, "--report", path("out.json")}, message);
    expect_rejected({"plan", scene}, message);
    EXPECT_FALSE(exists("out.json"));
  }
  void expect_no_scene_after(const std::function<void(nlohmann::json&)>& change, const std::string& message) const {
    nlohmann::json scene = scene_json();
    change(scene);
    expect_no_scene(write_scene("bad.json", scene), message);
  }
};

TEST_F(BadInput, MissingFile) {
  expect_no_volume("missing.nii.gz", "missing.nii.gz");
  expect_no_scene(path("missing.json"), "missing.json");
  expect_rejected({"run", path("scene.json"), "--replay", path("missing.json")}, "missing.json");
}

TEST_F(BadInput, Directory) {
  fs::create_directories(folder_ / "folder");
  expect_no_volume("folder", "folder");
  expect_no_scene(path("folder"), "folder");
}

TEST_F(BadInput, EmptyFile) {
  write("empty.nii.gz", "");
  expect_no_volume("empty.nii.gz", "empty");
  expect_no_scene(write("empty.json", ""), "empty");
}

TEST_F(BadInput, TruncatedCompressedVolume) {
  const std::string whole = text_of("image.nii.gz");
  for (const double share : {0.05, 0.5, 0.95}) {
    write("cut.nii.gz", whole.substr(0, static_cast<std::size_t>(static_cast<double>(whole.size()) * share)));
    expect_no_volume("cut.nii.gz", "cut.nii.gz", false);
  }
}

TEST_F(BadInput, TextWithTheExtensionOfAVolume) {
  write("text.nii", "This is no volume but a text that someone gave the wrong name.\n");
  expect_no_volume("text.nii", "text.nii");
}

/// `info` describes the file and reports that it cannot be loaded; --volume selects a volume of a 4D file.
TEST_F(BadInput, FourDimensionsAndColours) {
  const std::string header = "NRRD0004\ntype: uchar\ndimension: 4\nspace: LPS\nencoding: raw\n";
  const std::string x = "(1,0,0) ", y = "(0,1,0) ", z = "(0,0,1) ";
  write("time.nrrd", header + "sizes: 1 2 2 3\nspace directions: " + x + y + z +
                         "none\nkinds: domain domain domain time\n\n" + "aabcddefgghi");
  write("between.nrrd",
        header + "sizes: 1 3 2 2\nspace directions: " + x + "none " + y + z + "\n\n" + std::string(12, 'x'));
  write("colour.nrrd", header + "sizes: 3 1 2 2\nspace directions: none " + x + y + z +
                           "\nkinds: RGB-color domain domain domain\n\n" + std::string(12, 'x'));
  for (const auto& [name, message, shown] : {std::tuple{"between.nrrd", "4D", "3 volumes"},
                                             std::tuple{"colour.nrrd", "3 values per voxel", "3 values per voxel"}}) {
    for (const Arguments& arguments : {Arguments{"info", path(name)}, Arguments{"info", path(name), "--json"}}) {
      const Outcome outcome = call(arguments);
      EXPECT_EQ(outcome.status, 2) << name;
      EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
      EXPECT_NE(outcome.err.find("extract one of them"), std::string::npos) << outcome.err;
      EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
      if (arguments.size() == 2) {
        EXPECT_NE(outcome.out.find(shown), std::string::npos) << outcome.out;
      } else {
        EXPECT_EQ(nlohmann::json::parse(outcome.out)["size"], nlohmann::json({1, 2, 2}));
      }
    }
    expect_rejected({"compare", path(name), path("truth.nii.gz")}, message);
  }
  const Outcome second = call({"info", path("time.nrrd"), "--volume", "2", "--json"});
  EXPECT_EQ(second.status, 0) << second.err;
  const auto json = nlohmann::json::parse(second.out);
  EXPECT_EQ(json["frames"], 3);
  EXPECT_EQ(json["frame"], 2);
  EXPECT_EQ(json["range"], nlohmann::json({100, 102}));
  expect_rejected({"info", path("time.nrrd"), "--volume", "4"}, "it contains 3 volumes");
  EXPECT_NE(call({"compare", path("time.nrrd"), path("time.nrrd")}).err.find("volume 1 of"), std::string::npos);
}

/// A full disk: exit status 2, the old file is unchanged.
TEST_F(BadInput, DiskFullWhileWriting) {
  for (const char* name : {"out.mha", "out.nrrd", "out.nii", "out.nii.gz"}) {
    const std::string old(5000, 'o');
    write(name, old);
    rlimit kept{};
    ::getrlimit(RLIMIT_FSIZE, &kept);
    const rlimit limit{2000, kept.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    const Outcome outcome = call_program({"phantom", "sphere", path(name), "--size", "24", "--noise", "10"});
    ::setrlimit(RLIMIT_FSIZE, &kept);
    EXPECT_EQ(outcome.status, 2) << name;
    EXPECT_NE(outcome.err.find("File too large"), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(text_of(name) == old) << name;
  }
}

TEST_F(BadInput, SceneWithAnUnknownKey) {
  expect_no_scene_after([](nlohmann::json& scene) { scene["mesh"] = 1; }, "'meshes'");
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"][0]["forces"]["gradient"]["wait"] = 1; },
                        "'weight'");
}

TEST_F(BadInput, SceneWithNaN) {
  std::string text = scene_json().dump();
  text.replace(text.find("9}"), 1, "NaN");
  expect_no_scene(write("nan.json", text), "nan.json");
}

TEST_F(BadInput, SceneWithAMeshOutsideTheVolume) {
  expect_no_scene_after(
      [](nlohmann::json& scene) {
        scene["meshes"][0]["sphere"]["centre_mm"] = {1000, 0, 0};
      },
      "ball");
}

TEST_F(BadInput, SceneWithAMeshOfNoVertices) {
  const std::string header = "element face 0\nproperty list uchar int vertex_indices\nend_header\n";
  write("none.ply",
        "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n" + header);
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"][0]["pose"] = "none.ply"; }, "none.ply");
  write(
      "none.ply",
      "ply\nformat binary_little_endian 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n" +
          header);
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"][0]["pose"] = "none.ply"; }, "none.ply");
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"][0]["pose"] = "missing.ply"; }, "missing.ply");
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"][0]["final_vertices"] = 0; }, "final_vertices");
}

TEST_F(BadInput, SceneWithWrongTypesAndRanges) {
  expect_no_scene_after([](nlohmann::json& scene) { scene["steps"] = "many"; }, "steps");
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"][0]["sphere"]["radius_mm"] = 0; }, "radius_mm");
  expect_no_scene_after([](nlohmann::json& scene) { scene["simulation"]["damping"] = 2; }, "damping");
  expect_no_scene_after([](nlohmann::json& scene) { scene["meshes"].push_back(scene["meshes"][0]); }, "ball");
  expect_no_scene(write("broken.json", "{\"simplexseg_scene\": 1,"), "broken.json");
}

TEST_F(BadInput, ReferenceOrTestOutsideTheImage) {
  const Volume labels = read_volume(path("truth.nii.gz"));
  VolumeGeometry beside = labels.geometry();
  beside.origin_mm.x() += 1000;
  Volume other(beside, VoxelType::UInt8);
  other.voxels<std::uint8_t>()[0] = 1;
  write_volume(path("other.nii"), other);
  expect_rejected({"compare", path("truth.nii.gz"), path("other.nii")}, "grid");
  nlohmann::json scene = scene_json();
  scene["meshes"][0]["reference"]["labels"] = "other.nii";
  expect_rejected({"run", write_scene("bad.json", scene)}, "grid");
}

/// Regression: HDF5 printed errors about the open objects of a damaged file at the end of the program.
TEST_F(BadInput, LibrariesPrintNothingAtExit) {
  std::filesystem::path damaged;
  try {
    damaged =
        find_data("bad_input/tiny/hdf5_multiline.mnc", std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "../shared/data");
  } catch (const Error&) {
    GTEST_SKIP() << "no test data";
  }
  const Outcome outcome = call_program({"info", damaged.string()});
  EXPECT_EQ(outcome.status, 2);
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
}

TEST_F(BadInput, Usage) {
  const std::string scene = path("scene.json");
  expect_rejected({}, "subcommand");
  expect_rejected({"runn", scene}, "'run'");
  expect_rejected({"run"}, "SCENE");
  expect_rejected({"run", scene, "extra"}, "extra");
  expect_rejected({"run", scene, "--stepps", "1"}, "--stepps");
  expect_rejected({"run", scene, "--steps"}, "--steps");
  expect_rejected({"run", scene, "--steps", "-1"}, "--steps");
  expect_rejected({"run", scene, "--steps", "x"}, "--steps");
  expect_rejected({"run", scene, "--steps", "1", "--until-rest"}, "--until-settled");
  expect_rejected({"run", scene, "--backend", "gpu"}, "gpu");
  expect_rejected({"run", scene, "--threads", "0"}, "--threads");
  expect_rejected({"run", scene, "--backend", "cuda", "--threads", "2"}, "--threads");
  expect_rejected({"run", scene, "--set", "simulation.dampin=1"}, "'damping'");
  expect_rejected({"run", scene, "--set", "meshes.bal.gradient.weight=1"}, "'ball'");
  expect_rejected({"plan", scene, "--set", "forces.gradient.weight=-1"}, "range");
  expect_rejected({"run", scene, "--labels", path("none/out.nii")}, "none");
  expect_rejected({"run", scene, "--labels", path("out.tif")}, "out.tif");
  expect_rejected({"run", scene, "--labels", path("image.nii.gz")}, "image.nii.gz");
  expect_rejected({"run", scene, "--report", folder_.string()}, "folder");
  expect_rejected({"run", scene, "--report", scene}, "scene.json");
  expect_rejected({"run", scene, "--meshes", scene}, "scene.json");
  expect_rejected({"run", scene, "--picture", path("out.jpg")}, "out.jpg");
  expect_rejected({"study"}, "subcommand");
  expect_rejected({"study", "stability"}, "--out");
  expect_rejected({"study", "stability", "--out", path("x"), "--backend", "abacus"}, "abacus");
  expect_rejected({"study", "stability", "--out", path("x"), "--threads", "-1"}, "-1");
  expect_rejected({"study", "field-stability"}, "--out");
  expect_rejected({"study", "field-stability", "--out", path("x"), "--backend", "abacus"}, "abacus");
  expect_rejected({"study", "field-error-time", "--out", path("x")}, "IMAGE");
  expect_rejected({"study", "field-error-time", path("none.nii"), path("none.nii"), "--out", path("x")}, "none.nii");
  expect_rejected(
      {"study", "field-error-time", path("none.nii"), path("none.nii"), "--out", path("x"), "--clicks", "-1"}, "-1");
  expect_rejected({"phantom", "spere", path("out.nii")}, "spere");
  expect_rejected({"phantom", "sphere", path("out.nii"), path("two.nii")}, "OUT");
  expect_rejected({"phantom", "label-image", path("truth.nii.gz")}, "LABELS");
  expect_rejected({"phantom", "sphere", path("out.nii"), "--type", "int17"}, "int16");
  expect_rejected({"phantom", "sphere", path("out.nii"), "--size", "0"}, "size");
  expect_rejected({"phantom", "sphere", path("out.nii"), "--spacing", "nan"}, "spacing");
  expect_rejected({"phantom", "sphere", path("out.nii"), "--noise", "-1"}, "noise");
  expect_rejected({"phantom", "sphere", path("out.xyz")}, "out.xyz");
  expect_rejected({"phantom", "sphere", path("out.nii"), "--label", "1"}, "--label");
  expect_rejected({"compare", path("truth.nii.gz")}, "TEST");
  expect_rejected({"parameters", "--json", "--markdown"}, "--markdown");
  EXPECT_FALSE(exists("out.nii"));
}

TEST_F(BadInput, ALogThatDoesNotFitTheScene) {
  write(
      "log.json",
      R"({"simplexseg_log": 1, "entries": [{"after_steps": 1, "command": "delete_mesh", "mesh": 77}], "trailing_steps": 0})");
  expect_rejected({"run", path("scene.json"), "--replay", path("log.json")}, "77");
}

}  // namespace
}  // namespace simplexseg
