// SPDX-License-Identifier: Apache-2.0
#include "io/scene_io.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "core/error.h"
#include "io/parameter_text.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;

/// A folder that lives as long as the test.
class SceneIo : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("simplexseg-scene-" + std::to_string(::getpid()) + "-" +
                                           ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(folder_);
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  fs::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string text_of(const fs::path& path) const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  Scene read_text(const std::string& text) const { return read_scene(write("scene.json", text)).scene; }
  /// The message that the text is refused with; empty when it is taken.
  std::string refusal(const std::string& text) const {
    try {
      read_text(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  fs::path folder_;
};

std::string scene_with(const std::string& rest) { return "{\"simplexseg_scene\": 1, " + rest + "}"; }
std::string mesh_with(const std::string& rest) {
  return scene_with("\"meshes\": [{\"name\": \"a\", \"sphere\": {\"centre_mm\": [1, 2, 3], \"radius_mm\": 4}" +
                    (rest.empty() ? "" : ", " + rest) + "}]");
}

/// A float that needs all its digits.
float awkward(std::mt19937& random, float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); }

/// A value of the table's kind and range.
float any_value(std::mt19937& random, const ParameterInfo& info) {
  if (info.kind == ParameterKind::Real) return awkward(random, info.minimum, info.maximum);
  return static_cast<float>(std::uniform_int_distribution<int>(static_cast<int>(info.minimum), static_cast<int>(info.maximum))(random));
}

ForceParameters any_forces(std::mt19937& random) {
  ForceParameters forces{};
  for (const ForceInfo& force : force_list())
    for (std::size_t p = 0; p < force.parameters.size(); ++p)
      forces.values[static_cast<int>(force.id)][p] = any_value(random, force.parameters[p]);
  return forces;
}

MeshItem any_item(std::mt19937& random, ItemId id, const std::string& name) {
  MeshItem item;
  item.id = id;
  item.name = name;
  item.colour = {1, 200, static_cast<std::uint8_t>(id)};
  item.visible = id % 2 == 0;
  item.label = static_cast<int>(40 + id);
  item.seed = {{0.1 * id, -1.0 / 3, 1e-17}, 10 + 1.0 / 7};
  item.reference = Reference{"truth.nii", id % 2 ? std::optional(0.1) : std::nullopt};
  item.parameters = any_forces(random);
  item.mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, 1);
  for (Eigen::Vector3f& p : item.mesh.positions) {
    p *= awkward(random, 0.99f, 1.01f);
    item.previous.push_back(p * awkward(random, 0.99f, 1.01f));
    item.shape.push_back({awkward(random, -1, 1), awkward(random, -1, 1), awkward(random, -1, 1), awkward(random, 0, 1)});
    for (int s = 0; s < 9; ++s) item.profiles.push_back(awkward(random, -1000, 1000));
  }
  item.region.low = -0.1, item.region.high = 1e5 / 3;
  for (int b = 0; b < kRegionBins; ++b) item.region.object[b] = b * 7, item.region.background[b] = 1 << (b % 31);
  item.steps_at_level = 17;
  item.final_vertices = 5120;
  return item;
}

Scene any_scene() {
  std::mt19937 random(5);
  Scene scene;
  scene.volume_path = "nowhere/volume.nii.gz";
  for (std::size_t p = 0; p < simplexseg::simulation_table().size(); ++p)
    value_of(scene.simulation, static_cast<int>(p)) = any_value(random, simulation_table()[p]);
  scene.forces = any_forces(random);
  scene.meshes = {any_item(random, 3, "left"), any_item(random, 4, "right . \"Ångström\"")};
  scene.points = {{7, 4, {0.1, 1.0 / 3, -2e-300}}, {9, 3, {1e10, 5, 0}}};
  scene.steps = 123;
  return scene;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

// ---- reading ----

TEST_F(SceneIo, ReadsEveryKey) {
  const Scene scene = read_text(scene_with(R"(
    "simulation": {"damping": 0.25, "limit_timestep": "off", "refresh_interval": 5},
    "forces": {"gradient": {"weight": 2, "object": "dark"}},
    "meshes": [
      {"name": "brain", "sphere": {"centre_mm": [1, -2, 3.5], "radius_mm": 40}, "colour": "#0aFf10", "visible": false, "label": 9,
       "forces": {"gradient": {"weight": 3}}, "final_vertices": 1280, "reference": {"labels": "truth.nii", "value": 2}},
      {"name": "other", "sphere": {"centre_mm": [0, 0, 0], "radius_mm": 1}, "reference": {"labels": "truth.nii"}}],
    "attraction_points": [{"mesh": "other", "position_mm": [4, 5, 6]}], "steps": 400)"));
  EXPECT_EQ(scene.simulation.damping, 0.25f);
  EXPECT_EQ(scene.simulation.limit_timestep, 0);
  EXPECT_EQ(scene.simulation.refresh_interval, 5);
  EXPECT_EQ(scene.simulation.timestep, default_simulation_parameters().timestep);
  ASSERT_EQ(scene.meshes.size(), 2u);
  const MeshItem& brain = scene.meshes[0];
  EXPECT_EQ(brain.seed.centre_mm, Eigen::Vector3d(1, -2, 3.5));
  EXPECT_EQ(brain.seed.radius_mm, 40);
  EXPECT_EQ(brain.colour, (Colour{10, 255, 16}));
  EXPECT_FALSE(brain.visible);
  EXPECT_EQ(brain.label, 9);
  EXPECT_EQ(brain.final_vertices, 1280);
  EXPECT_EQ(brain.reference->labels, "truth.nii");
  EXPECT_EQ(brain.reference->value, 2);
  EXPECT_EQ(brain.parameters.weight(ForceId::Gradient), 3);
  EXPECT_EQ(scene.meshes[1].parameters.weight(ForceId::Gradient), 2);
  EXPECT_FALSE(scene.meshes[1].reference->value);
  const int object = find_parameter(find_force("gradient")->parameters, "object");
  for (const MeshItem& item : scene.meshes) EXPECT_EQ(item.parameters.values[static_cast<int>(ForceId::Gradient)][object], 2);
  EXPECT_EQ(scene.forces.weight(ForceId::Gradient), 2);
  ASSERT_EQ(scene.points.size(), 1u);
  EXPECT_EQ(scene.points[0].mesh, scene.meshes[1].id);
  EXPECT_EQ(scene.points[0].position_mm, Eigen::Vector3d(4, 5, 6));
  EXPECT_EQ(scene.steps, 400);
}

TEST_F(SceneIo, EveryParameterOfEveryTableIsReadAndMayNotLeaveItsRange) {
  const auto check = [&](const std::string& before, const ParameterInfo& info, const std::string& after, auto value_in) {
    const float value = info.kind == ParameterKind::Real ? (info.minimum + info.maximum) / 2 : info.maximum;
    const std::string quote = info.kind == ParameterKind::Choice ? "\"" : "";
    const std::string text = before + "\"" + info.name + "\": " + quote + parameter_to_text(info, value) + quote + after;
    EXPECT_EQ(value_in(read_text(scene_with(text))), value) << text;
    for (const std::string wrong : {"null", "[1]", "\"nonsense\"", "true"}) {
      EXPECT_NE(refusal(scene_with(before + "\"" + info.name + "\": " + wrong + after)).find(info.name), std::string::npos) << text << wrong;
    }
    if (info.kind == ParameterKind::Choice) return;
    const double width = std::max(1.0, static_cast<double>(info.maximum - info.minimum));
    for (const double wrong : {info.minimum - width / 8 - 1, info.maximum + width / 8 + 1}) {
      const std::string message = refusal(scene_with(before + "\"" + info.name + "\": " + std::to_string(wrong) + after));
      EXPECT_NE(message.find("out of range"), std::string::npos) << text << wrong << message;
    }
  };
  for (std::size_t p = 0; p < simulation_table().size(); ++p) {
    check("\"simulation\": {", simulation_table()[p], "}", [p](const Scene& s) { return value_of(s.simulation, static_cast<int>(p)); });
  }
  for (const ForceInfo& force : force_list()) {
    for (std::size_t p = 0; p < force.parameters.size(); ++p) {
      check("\"forces\": {\"" + std::string(force.name) + "\": {", force.parameters[p], "}}",
            [&, p](const Scene& s) { return s.forces.values[static_cast<int>(force.id)][p]; });
    }
  }
}

TEST_F(SceneIo, RefusesInOneLineThatNamesFileAndPlace) {
  const std::string sphere = R"("sphere": {"centre_mm": [1, 2, 3], "radius_mm": 4})";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "empty"},
      {" \n", "empty"},
      {"{", "line 1"},
      {"{\n \"simplexseg_scene\": 1,\n \"steps\": NaN}", "line 3, column 11"},
      {scene_with("\"steps\": Infinity"), "line 1"},
      {scene_with("\"steps\": 1e999"), "scene.json"},
      {scene_with("\"steps\": null"), "steps"},
      {scene_with("\"steps\": -1"), "steps"},
      {scene_with("\"steps\": 1.5"), "steps"},
      {scene_with("\"steps\": 1, \"steps\": 2"), "twice"},
      {scene_with("\"steps\": 1} x {"), "line 1"},
      {"[]", "object"},
      {"3", "object"},
      {"{}", "simplexseg_scene"},
      {"{\"simplexseg_scene\": 2}", "simplexseg_scene"},
      {scene_with("\"volumes\": \"a\""), "'volume'"},
      {scene_with("\"volume\": \"no_such_file.nii\""), "no_such_file.nii"},
      {scene_with("\"volume\": \"\""), "volume"},
      {scene_with("\"volume\": 3"), "volume"},
      {scene_with("\"simulation\": {\"dampin\": 1}"), "'damping'"},
      {scene_with("\"simulation\": 3"), "simulation"},
      {scene_with("\"forces\": {\"gradent\": {}}"), "'gradient'"},
      {scene_with("\"forces\": {\"gradient\": {\"wieght\": 1}}"), "'weight'"},
      {scene_with("\"forces\": {\"gradient\": {\"object\": \"brigt\"}}"), "'bright'"},
      {scene_with("\"forces\": {\"gradient\": {\"samples\": 2.5}}"), "whole"},
      {scene_with("\"meshes\": {}"), "meshes"},
      {scene_with("\"meshes\": [3]"), "meshes[0]"},
      {scene_with("\"meshes\": [{" + sphere + "}]"), "'name'"},
      {scene_with("\"meshes\": [{\"name\": \"\", " + sphere + "}]"), "meshes[0].name"},
      {scene_with("\"meshes\": [{\"name\": \"a\"}]"), "'sphere'"},
      {scene_with("\"meshes\": [{\"name\": \"a\", " + sphere + "}, {\"name\": \"a\", " + sphere + "}]"), "meshes[1].name"},
      {mesh_with("\"colour\": \"red\""), "meshes[0].colour"},
      {mesh_with("\"colour\": \"#12345\""), "meshes[0].colour"},
      {mesh_with("\"colour\": \"#12345g\""), "meshes[0].colour"},
      {mesh_with("\"color\": \"#123456\""), "'colour'"},
      {mesh_with("\"visible\": 1"), "meshes[0].visible"},
      {mesh_with("\"label\": 0"), "meshes[0].label"},
      {mesh_with("\"label\": 65536"), "meshes[0].label"},
      {mesh_with("\"final_vertices\": 0"), "meshes[0].final_vertices"},
      {mesh_with("\"forces\": {\"smoothing\": {\"weight\": \"1\"}}"), "meshes[0].forces.smoothing.weight"},
      {mesh_with("\"forces\": {\"smoothing\": {\"weigth\": 1}}"), "meshes[0].forces.smoothing"},
      {mesh_with("\"reference\": {}"), "'labels'"},
      {mesh_with("\"reference\": {\"labels\": \"a\", \"label\": 1}"), "meshes[0].reference"},
      {mesh_with("\"pose\": \"missing.ply\""), "missing.ply"},
      {mesh_with("\"state\": \"missing.state\""), "pose"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2], "radius_mm": 4}}])"), "centre_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, null], "radius_mm": 4}}])"), "centre_mm[2]"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, 3], "radius_mm": 0}}])"), "radius_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"centre_mm": [1, 2, 3], "radius_mm": -1}}])"), "radius_mm"},
      {scene_with(R"("meshes": [{"name": "a", "sphere": {"center_mm": [1, 2, 3], "radius_mm": 1}}])"), "'centre_mm'"},
      {scene_with(R"("attraction_points": [{"mesh": "a", "position_mm": [1, 2, 3]}])"), "attraction_points[0].mesh"},
      {scene_with(R"("attraction_points": [{"position_mm": [1, 2, 3]}])"), "attraction_points[0]"},
  };
  for (const auto& [text, says] : cases) {
    const std::string message = refusal(text);
    EXPECT_NE(message.find(says), std::string::npos) << text << "\n" << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    if (says == "no_such_file.nii" || says == "missing.ply") continue;
    EXPECT_NE(message.find("scene.json"), std::string::npos) << message;
  }
}

TEST_F(SceneIo, RefusesMissingFilesFoldersAndForeignBytes) {
  EXPECT_THROW(read_scene(folder_ / "none.json"), Error);
  EXPECT_THROW(read_scene(folder_), Error);
  EXPECT_THROW(read_scene(write("bytes.json", std::string("\0\xff\x1f\x8b", 4))), Error);
  EXPECT_THROW(read_scene(write("deep.json", std::string(100000, '['))), Error);
  EXPECT_THROW(read_log(folder_ / "none.json"), Error);
  EXPECT_THROW(read_log(write("scene.json", scene_with("\"steps\": 1"))), Error);
}

TEST_F(SceneIo, RefusesAPoseWithoutVertices) {
  write("empty.ply", "ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nproperty float z\n"
                     "element face 0\nproperty list uchar int vertex_indices\nend_header\n");
  const std::string message = refusal(mesh_with("\"pose\": \"empty.ply\""));
  EXPECT_NE(message.find("empty.ply"), std::string::npos) << message;
}

// ---- paths ----

TEST_F(SceneIo, FindsDataBesideTheSceneThenInTheFoldersOfData) {
  const char* const was = std::getenv("SIMPLEXSEG_DATA");
  const std::string before = was ? was : "";
  fs::create_directories(folder_ / "one");
  fs::create_directories(folder_ / "two");
  fs::create_directories(folder_ / "scenes");
  write("two/image.nii", "2");
  setenv("SIMPLEXSEG_DATA", ((folder_ / "one").string() + ":" + (folder_ / "two").string()).c_str(), 1);
  EXPECT_EQ(find_data("image.nii", folder_ / "scenes"), folder_ / "two/image.nii");
  write("one/image.nii", "1");
  EXPECT_EQ(find_data("image.nii", folder_ / "scenes"), folder_ / "one/image.nii");
  write("scenes/image.nii", "0");
  EXPECT_EQ(find_data("image.nii", folder_ / "scenes"), folder_ / "scenes/image.nii");
  EXPECT_EQ(find_data((folder_ / "two/image.nii").string(), folder_), folder_ / "two/image.nii");
  try {
    find_data("nowhere.nii", folder_ / "scenes");
    ADD_FAILURE() << "found";
  } catch (const Error& error) {
    for (const char* place : {"scenes/nowhere.nii", "one/nowhere.nii", "two/nowhere.nii", "mricron"})
      EXPECT_NE(std::string(error.what()).find(place), std::string::npos) << error.what();
  }
  was ? setenv("SIMPLEXSEG_DATA", before.c_str(), 1) : unsetenv("SIMPLEXSEG_DATA");
}

TEST_F(SceneIo, ASceneSavedElsewhereStillFindsItsVolume) {
  write("image.nii", "x");
  const SceneFile first = read_scene(write("scene.json", scene_with("\"volume\": \"image.nii\"")));
  EXPECT_EQ(first.volume, folder_ / "image.nii");
  fs::create_directories(folder_ / "elsewhere");
  write_scene(folder_ / "elsewhere/scene.json", first.scene);
  EXPECT_TRUE(fs::equivalent(read_scene(folder_ / "elsewhere/scene.json").volume, folder_ / "image.nii"));
  // In its own folder it names it relative to the folder, so that both may be moved.
  write_scene(folder_ / "saved.json", first.scene);
  fs::rename(folder_ / "saved.json", folder_ / "elsewhere/saved.json");
  fs::rename(folder_ / "image.nii", folder_ / "elsewhere/image.nii");
  EXPECT_TRUE(fs::equivalent(read_scene(folder_ / "elsewhere/saved.json").volume, folder_ / "elsewhere/image.nii"));
}

// ---- writing ----

TEST_F(SceneIo, RoundTripKeepsEveryBit) {
  const Scene before = any_scene();
  Scene named = before;
  named.volume_path.clear();   // the volume must exist to be read again
  write_scene(folder_ / "Übung.json", named);
  const Scene after = read_scene(folder_ / "Übung.json").scene;

  EXPECT_TRUE(same_bits(before.simulation, after.simulation));
  EXPECT_TRUE(same_bits(before.forces, after.forces));
  EXPECT_EQ(before.steps, after.steps);
  ASSERT_EQ(before.meshes.size(), after.meshes.size());
  for (std::size_t m = 0; m < before.meshes.size(); ++m) {
    const MeshItem &a = before.meshes[m], &b = after.meshes[m];
    SCOPED_TRACE(a.name);
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.colour, b.colour);
    EXPECT_EQ(a.visible, b.visible);
    EXPECT_EQ(a.label, b.label);
    EXPECT_TRUE(same_bits(a.seed.centre_mm, b.seed.centre_mm));
    EXPECT_EQ(a.seed.radius_mm, b.seed.radius_mm);
    EXPECT_EQ(a.reference->labels, b.reference->labels);
    EXPECT_EQ(a.reference->value, b.reference->value);
    EXPECT_TRUE(same_bits(a.parameters, b.parameters));
    EXPECT_TRUE(same_bits(a.mesh.positions, b.mesh.positions));
    EXPECT_TRUE(same_bits(a.mesh.neighbours, b.mesh.neighbours));
    EXPECT_TRUE(same_bits(a.previous, b.previous));
    EXPECT_TRUE(same_bits(a.shape, b.shape));
    EXPECT_TRUE(same_bits(a.profiles, b.profiles));
    EXPECT_TRUE(same_bits(a.region, b.region));
    EXPECT_EQ(a.steps_at_level, b.steps_at_level);
    EXPECT_EQ(a.final_vertices, b.final_vertices);
  }
  ASSERT_EQ(after.points.size(), before.points.size());
  for (std::size_t p = 0; p < before.points.size(); ++p) {
    EXPECT_TRUE(same_bits(before.points[p].position_mm, after.points[p].position_mm));
    EXPECT_EQ(before.find_mesh(before.points[p].mesh)->name, after.find_mesh(after.points[p].mesh)->name);
  }
  // Written again, the file is the same text.
  write_scene(folder_ / "again.json", after);
  std::string first = text_of(folder_ / "Übung.json"), second = text_of(folder_ / "again.json");
  for (const auto& [from, to] : {std::pair{"Übung", "X"}, {"again", "X"}, {"mesh-3", "mesh-1"}, {"mesh-4", "mesh-2"}})
    for (std::string* text : {&first, &second})
      for (std::size_t at; (at = text->find(from)) != std::string::npos;) text->replace(at, std::strlen(from), to);
  EXPECT_EQ(first, second);
}

TEST_F(SceneIo, AStateOfAnotherPoseOrCutShortIsRefused) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  write_scene(folder_ / "scene.json", scene);
  const std::string state = text_of(folder_ / "scene.mesh-3.state");
  write("scene.mesh-3.state", text_of(folder_ / "scene.mesh-4.state"));
  EXPECT_THROW(read_scene(folder_ / "scene.json"), Error);
  for (const std::size_t length : {std::size_t{0}, std::size_t{10}, state.size() / 2, state.size() - 1}) {
    write("scene.mesh-3.state", state.substr(0, length));
    EXPECT_THROW(read_scene(folder_ / "scene.json"), Error) << length;
  }
  write("scene.mesh-3.state", state);
  EXPECT_NO_THROW(read_scene(folder_ / "scene.json"));
}

TEST_F(SceneIo, AWriteThatFailsLeavesTheOldFilesAlone) {
  Scene scene = any_scene();
  scene.volume_path.clear();
  write_scene(folder_ / "scene.json", scene);
  const std::string before = text_of(folder_ / "scene.json"), pose = text_of(folder_ / "scene.mesh-3.ply");
  Scene broken = scene;
  broken.meshes[0].mesh.positions[0] *= 1.5f;
  broken.meshes[1].mesh.positions[0].x() = std::nanf("");
  EXPECT_THROW(write_scene(folder_ / "scene.json", broken), Error);
  broken = scene;
  broken.meshes[1].name = broken.meshes[0].name;
  EXPECT_THROW(write_scene(folder_ / "scene.json", broken), Error);
  EXPECT_EQ(text_of(folder_ / "scene.json"), before);
  EXPECT_TRUE(text_of(folder_ / "scene.mesh-3.ply") == pose);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 5);   // nothing half-written stays behind
  EXPECT_THROW(write_scene(folder_ / "none" / "scene.json", scene), Error);
  EXPECT_THROW(write_scene(folder_, scene), Error);
}

// ---- --set ----

TEST_F(SceneIo, SetByPathChangesWhatItNamesAndNothingElse) {
  Scene scene = any_scene();
  scene.meshes[1].name = "b.c";
  const Scene before = scene;
  set_by_path(scene, "meshes.b.c.gradient.weight=1.25");
  EXPECT_EQ(scene.meshes[1].parameters.weight(ForceId::Gradient), 1.25f);
  EXPECT_TRUE(same_bits(scene.meshes[0].parameters, before.meshes[0].parameters));
  EXPECT_TRUE(same_bits(scene.forces, before.forces));
  set_by_path(scene, "forces.region.weight=0.5");
  for (const MeshItem& item : scene.meshes) EXPECT_EQ(item.parameters.weight(ForceId::Region), 0.5f);
  EXPECT_EQ(scene.forces.weight(ForceId::Region), 0.5f);
  set_by_path(scene, "forces.gradient.object=dark");
  EXPECT_EQ(scene.meshes[0].parameters.values[static_cast<int>(ForceId::Gradient)][find_parameter(find_force("gradient")->parameters, "object")], 2);
  set_by_path(scene, "simulation.damping=1e-1");
  EXPECT_EQ(scene.simulation.damping, 0.1f);
}

TEST_F(SceneIo, SetByPathRefusesAndNamesTheNearest) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "="}, {"simulation.damping", "="}, {"=1", "meshes.NAME"}, {"simulation.dampin=1", "'damping'"},
      {"simulation.damping=", "number"}, {"simulation.damping=x", "number"}, {"simulation.damping=1x", "number"},
      {"simulation.damping=nan", "finite"}, {"simulation.damping=inf", "finite"}, {"simulation.damping=7", "range"},
      {"forces.gradient.wait=1", "'weight'"}, {"forces.gradeint.weight=1", "'gradient'"}, {"forces.gradient.object=dirk", "'dark'"},
      {"meshes.lift.gradient.weight=1", "'left'"}, {"damping=1", "meshes.NAME"}, {"simulation.refresh_interval=2.5", "whole"}};
  for (const auto& [assignment, says] : cases) {
    Scene scene = any_scene();
    try {
      set_by_path(scene, assignment);
      ADD_FAILURE() << assignment << " was taken";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
  }
}

// ---- logs ----

TEST_F(SceneIo, ALogKeepsEveryCommandAndEveryBit) {
  const Eigen::Vector3d p(0.1, 1.0 / 3, -2.5e-310);
  std::vector<LogEntry> log = {
      {0, AddMesh{"a \"quoted\" näme", {p, 10.0 / 3}, Colour{1, 2, 3}, 7}},
      {3, AddMesh{"", {p, 1}, std::nullopt, 0}},
      {1, DeleteMesh{4}},
      {2, EditMesh{5, "name", Colour{9, 8, 7}, false, 12}},
      {0, EditMesh{5, std::nullopt, std::nullopt, std::nullopt, std::nullopt}},
      {7, SetSimulationParameter{find_parameter(simulation_table(), "damping"), 0.1f}},
      {7, SetSimulationParameter{find_parameter(simulation_table(), "limit_timestep"), 0}},
      {1000000, AddAttractionPoint{5, p}},
      {1, MoveAttractionPoint{6, p, true}},
      {1, MoveAttractionPoint{6, -p, false}},
      {1, DeleteAttractionPoint{6}},
      {1, ResetPose{0}},
      {1, RecordProfiles{1}},
      {1, RefineMesh{2}},
      {1, Undo{}},
      {1, Redo{}},
  };
  std::mt19937 random(9);
  for (const ForceInfo& force : force_list())
    for (std::size_t k = 0; k < force.parameters.size(); ++k)
      log.push_back({2, SetForceParameter{3, force.id, static_cast<int>(k), any_value(random, force.parameters[k])}});
  write_log(folder_ / "log.json", log, 55, "scene.json");
  const LogFile file = read_log(folder_ / "log.json");
  EXPECT_EQ(file.trailing_steps, 55);
  EXPECT_EQ(file.scene, "scene.json");
  ASSERT_EQ(file.log.size(), log.size());

  const auto get = [&]<class C>(std::type_identity<C>, std::size_t at) {
    return std::pair(std::get<C>(log[at].command), std::get<C>(file.log[at].command));
  };
  for (std::size_t e = 0; e < log.size(); ++e) {
    EXPECT_EQ(log[e].steps, file.log[e].steps);
    ASSERT_EQ(log[e].command.index(), file.log[e].command.index()) << e;
  }
  for (const std::size_t at : {0u, 1u}) {
    const auto [a, b] = get(std::type_identity<AddMesh>{}, at);
    EXPECT_EQ(a.name, b.name);
    EXPECT_TRUE(same_bits(a.seed.centre_mm, b.seed.centre_mm));
    EXPECT_EQ(a.seed.radius_mm, b.seed.radius_mm);
    EXPECT_EQ(a.colour, b.colour);
    EXPECT_EQ(a.like, b.like);
  }
  for (const std::size_t at : {3u, 4u}) {
    const auto [a, b] = get(std::type_identity<EditMesh>{}, at);
    EXPECT_TRUE(a.mesh == b.mesh && a.name == b.name && a.colour == b.colour && a.visible == b.visible && a.label == b.label);
  }
  for (const std::size_t at : {5u, 6u}) {
    const auto [a, b] = get(std::type_identity<SetSimulationParameter>{}, at);
    EXPECT_TRUE(a.parameter == b.parameter && same_bits(a.value, b.value));
  }
  const auto [added, added_again] = get(std::type_identity<AddAttractionPoint>{}, 7);
  EXPECT_TRUE(added.mesh == added_again.mesh && same_bits(added.position_mm, added_again.position_mm));
  for (const std::size_t at : {8u, 9u}) {
    const auto [a, b] = get(std::type_identity<MoveAttractionPoint>{}, at);
    EXPECT_TRUE(a.point == b.point && a.continues == b.continues && same_bits(a.position_mm, b.position_mm));
  }
  EXPECT_EQ(std::get<DeleteMesh>(file.log[2].command).mesh, 4u);
  EXPECT_EQ(std::get<DeleteAttractionPoint>(file.log[10].command).point, 6u);
  EXPECT_EQ(std::get<ResetPose>(file.log[11].command).mesh, 0u);
  EXPECT_EQ(std::get<RecordProfiles>(file.log[12].command).mesh, 1u);
  EXPECT_EQ(std::get<RefineMesh>(file.log[13].command).mesh, 2u);
  for (std::size_t at = 16; at < log.size(); ++at) {
    const auto [a, b] = get(std::type_identity<SetForceParameter>{}, at);
    EXPECT_TRUE(a.mesh == b.mesh && a.force == b.force && a.parameter == b.parameter && same_bits(a.value, b.value)) << at;
  }
}

TEST_F(SceneIo, ABrokenLogIsRefused) {
  const auto log_with = [](const std::string& entry) {
    return "{\"simplexseg_log\": 1, \"entries\": [" + entry + "], \"trailing_steps\": 0}";
  };
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"{\"simplexseg_log\": 1, \"entries\": []}", "trailing_steps"},
      {"{\"simplexseg_log\": 1, \"entries\": [], \"trailing_steps\": 1, \"x\": 1}", "'x'"},
      {log_with("{\"command\": \"undo\"}"), "after_steps"},
      {log_with("{\"after_steps\": -1, \"command\": \"undo\"}"), "after_steps"},
      {log_with("{\"after_steps\": 1, \"command\": \"undoo\"}"), "'undo'"},
      {log_with("{\"after_steps\": 1, \"command\": \"undo\", \"mesh\": 1}"), "'mesh'"},
      {log_with("{\"after_steps\": 1, \"command\": \"move_point\", \"point\": 1}"), "position_mm"},
      {log_with("{\"after_steps\": 1, \"command\": \"move_point\", \"point\": 1, \"position_mm\": [1, 2, NaN]}"), "line 1"},
      {log_with("{\"after_steps\": 1, \"command\": \"delete_mesh\", \"mesh\": -1}"), "entries[0].mesh"},
      {log_with(R"({"after_steps": 1, "command": "set_force_parameter", "mesh": 0, "force": "gradient", "parameter": "wait", "value": 1})"), "'weight'"},
      {log_with(R"({"after_steps": 1, "command": "set_force_parameter", "mesh": 0, "force": "gradient", "parameter": "weight", "value": null})"), "value"},
  };
  for (const auto& [text, says] : cases) {
    try {
      read_log(write("log.json", text));
      ADD_FAILURE() << text << " was taken";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("log.json"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace simplexseg
