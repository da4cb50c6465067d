// SPDX-License-Identifier: Apache-2.0
#include "io/scene/label_preset.h"

#include <cstdlib>
#include <fstream>
#include <map>
#include <set>

#include "io/scene/scene_export.h"
#include "io/volume/volume_io.h"
#include "mesh/iso_surface.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::error_of;

const LabelPreset& preset_named(const std::string& name) {
  for (const LabelPreset& preset : label_presets())
    if (preset.name == name) return preset;
  throw std::runtime_error("no preset " + name);
}

std::vector<std::string> names_of(const std::vector<const PresetLabel*>& labels) {
  std::vector<std::string> names;
  for (const PresetLabel* label : labels) names.push_back(label->name);
  return names;
}

TEST(LabelPresets, OfTheProgramAreCompleteAndConsistent) {
  std::map<std::string, std::size_t> sizes;
  std::map<std::string, PresetLabel> known;
  for (const LabelPreset& preset : label_presets()) {
    SCOPED_TRACE(preset.name);
    sizes[preset.name] = preset.labels.size();
    EXPECT_FALSE(preset.title.empty());
    std::set<std::string> names;
    std::set<int> labels;
    std::set<std::vector<int>> colours;
    for (const PresetLabel& label : preset.labels) {
      SCOPED_TRACE(label.name);
      EXPECT_TRUE(names.insert(label.name).second);
      EXPECT_TRUE(labels.insert(label.label).second);
      EXPECT_TRUE(colours.insert({label.colour.red, label.colour.green, label.colour.blue}).second);
      EXPECT_EQ(fault_of(label.code), "");
      EXPECT_FALSE(label.code.empty());
      const auto same = known.emplace(label.name, label).first;
      EXPECT_EQ(same->second.code, label.code) << "in another preset";
      EXPECT_EQ(same->second.colour, label.colour) << "in another preset";
      const bool left = label.name.starts_with("Left ") && !label.name.starts_with("Left atri") &&
                        !label.name.starts_with("Left ventricle");
      EXPECT_EQ(label.code.modifier.value, left                                                         ? "7771000"
                                           : label.name.starts_with("Right ") && preset.name != "heart" ? "24028007"
                                                                                                        : "");
      EXPECT_EQ(code_of_name(label.name), label.code);
      for (const std::string& synonym : label.synonyms) EXPECT_EQ(code_of_name(synonym), label.code) << synonym;
    }
  }
  EXPECT_EQ(sizes.size(), 5u);
  EXPECT_GE(sizes["abdomen"], 20u);
  EXPECT_GE(sizes["spine"], 28u);
  EXPECT_GE(sizes["brain"], 30u);
  EXPECT_GE(sizes["heart"], 9u);
  EXPECT_GE(sizes["head-neck"], 30u);
  EXPECT_EQ(preset_named("abdomen").by_name().at("Left kidney"), 3) << "number of BTCV and AMOS";
  EXPECT_EQ(preset_named("spine").by_name().at("L5 vertebra"), 24) << "number of VerSe";
  EXPECT_EQ(preset_named("brain").by_name().at("Right hippocampus"), 53) << "number of FreeSurfer";
}

TEST(LabelPresets, HaveTheCodesOfDicom) {
  if (std::system("/usr/bin/python3 -c 'import pydicom' 2>/dev/null") != 0) GTEST_SKIP() << "python3-pydicom is absent";
  const std::string source = SIMPLEXSEG_SOURCE_DIR;
  EXPECT_EQ(
      std::system(
          ("/usr/bin/python3 '" + source + "/tests/io/check_codes.py' '" + source + "'/data/labels/*.json").c_str()),
      0);
}

TEST(LabelPresets, OnlyNamesWithTheWordsOfAStructureHaveItsCodes) {
  for (const char* name : {"kidney_LEFT 2", "Left kidney", "Kidney L", "lt kidney"}) {
    EXPECT_EQ(code_of_name(name).type.value, "64033007") << name;
    EXPECT_EQ(code_of_name(name).modifier.value, "7771000") << name;
  }
  EXPECT_EQ(code_of_name("Liver").type, (CodedConcept{"SCT", "10200004", "Liver"}));
  EXPECT_EQ(code_of_name("Liver").category, (CodedConcept{"SCT", "123037004", "Anatomical Structure"}));
  EXPECT_EQ(code_of_name("esophagus"), code_of_name("Oesophagus"));
  EXPECT_EQ(code_of_name("tumor 3").category.value, "49755003");
  EXPECT_EQ(code_of_name("Th7").type.value, "62487009");
  for (const char* other : {"liver tumour", "", "mesh 1", "kidney cyst left", "not liver", "7"})
    EXPECT_EQ(code_of_name(other), tissue_code()) << other;
  MeshItem item;
  item.name = "Liver";
  item.code = code_of_name("Spleen");
  EXPECT_EQ(code_of(item).type.value, "78961009") << "the chosen code, not that of the name";
}

TEST(LabelPresets, TwoLettersSuggestAStructure) {
  const std::vector<PresetLabel>& abdomen = preset_named("abdomen").labels;
  const auto first = [&](const std::string& typed) { return matching_labels(abdomen, typed).at(0)->name; };
  EXPECT_EQ(first("sp"), "Spleen");
  EXPECT_EQ(first("LI"), "Liver");
  EXPECT_EQ(first("lk"), "Left kidney") << "by initials";
  EXPECT_EQ(first("ra"), "Right adrenal gland");
  EXPECT_EQ(first("es"), "Oesophagus") << "by a synonym";
  EXPECT_EQ(first("pa"), "Pancreas");
  EXPECT_EQ(names_of(matching_labels(abdomen, "ki")),
            (std::vector<std::string>{"Kidney", "Right kidney", "Left kidney"}));
  EXPECT_EQ(matching_labels(abdomen, "").size(), abdomen.size());
  EXPECT_TRUE(matching_labels(abdomen, "xq").empty());
  const std::vector<PresetLabel>& spine = preset_named("spine").labels;
  EXPECT_EQ(names_of(matching_labels(spine, "t12")), std::vector<std::string>{"T12 vertebra"});
  std::vector<PresetLabel> twice = abdomen;
  twice.insert(twice.end(), abdomen.begin(), abdomen.end());
  EXPECT_EQ(names_of(matching_labels(twice, "spl")),
            (std::vector<std::string>{"Spleen", "Splenic vein", "Portal and splenic vein"}))
      << "once each";
}

class LabelPresetFiles : public test::FolderTest {
 protected:
  std::string write(const std::string& text) const {
    std::ofstream(folder / "own.json") << text;
    return (folder / "own.json").string();
  }
  std::string refusal(const std::string& text) const {
    return error_of([&] { read_label_preset(write(text)); });
  }
  static std::string with(const std::string& labels) {
    return R"({"simplexseg_labels": 1, "title": "Own", "labels": [)" + labels + "]}";
  }
};

TEST_F(LabelPresetFiles, OfUsersAreReadAndRoundTrip) {
  const std::string path = write(with(
      R"({"name": "Implant", "number": 300, "colour": "#0102ff", "synonyms": ["screw"],
          "category": {"code": "260787004", "meaning": "Physical object"}, "type": {"scheme": "99X", "code": "A", "meaning": "Schraube"}},
         {"name": "Plain", "number": 2, "colour": "#ffffff"},
         {"name": "Left half", "number": 3, "colour": "#00ff00", "type": {"code": "10200004", "meaning": "Liver"},
          "modifier": {"code": "7771000", "meaning": "Left"}})"));
  const LabelPreset preset = find_label_preset(path);
  EXPECT_EQ(preset.name, path);
  EXPECT_EQ(preset.title, "Own");
  ASSERT_EQ(preset.labels.size(), 3u);
  EXPECT_EQ(preset.labels[0].code.type, (CodedConcept{"99X", "A", "Schraube"}));
  EXPECT_EQ(preset.labels[0].code.category.value, "260787004");
  EXPECT_EQ(preset.labels[0].colour, (Colour{1, 2, 255}));
  EXPECT_TRUE(preset.labels[1].code.empty());
  EXPECT_EQ(preset.labels[2].code.category.value, "123037004") << "the default";
  EXPECT_EQ(preset.by_name(), (std::map<std::string, int>{{"Implant", 300}, {"Plain", 2}, {"Left half", 3}}));
  EXPECT_EQ(find_label(preset.labels, "SCREW 4"), &preset.labels[0]);
  for (const LabelPreset& one : {preset, preset_named("abdomen")}) {
    const LabelPreset again = read_label_preset(write(label_preset_text(one)));
    ASSERT_EQ(again.labels.size(), one.labels.size());
    EXPECT_EQ(label_preset_text(again), label_preset_text(one));
    for (std::size_t l = 0; l < one.labels.size(); ++l) EXPECT_EQ(again.labels[l].code, one.labels[l].code);
  }
}

TEST_F(LabelPresetFiles, ThatAreInvalidAreRefusedInOneLine) {
  const std::string good = R"("number": 1, "colour": "#ffffff")";
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"", "own.json"},
      {"[1]", "own.json"},
      {"{}", "not a label preset"},
      {R"({"simplexseg_labels": 2, "title": "a", "labels": []})", "simplexseg_labels"},
      {with(""), "no label"},
      {with(R"({"name": "a", )" + good + "}, " + R"({"name": "A", "number": 2, "colour": "#ffffff"})"), "the name 'A'"},
      {with(R"({"name": "a", )" + good + "}, " + R"({"name": "b", )" + good + "}"), "the number 1"},
      {with(R"({"name": "a", "number": 0, "colour": "#ffffff"})"), "labels[0].number"},
      {with(R"({"name": "a", "number": 1, "colour": "red"})"), "'red' is not a colour"},
      {with(R"({"name": "", )" + good + "}"), "labels[0].name"},
      {with(R"({"name": "a\nb", )" + good + "}"), "line break"},
      {with(R"({"name": "a", "x": 1, )" + good + "}"), "'x'"},
      {with(R"({"name": "a", "type": {"code": "1"}, )" + good + "}"), "meaning"},
      {with(R"({"name": "a", "type": {"code": "12345678901234567", "meaning": "b"}, )" + good + "}"), "16 characters"},
      {with(R"({"name": "a", "type": {"code": "1", "meaning": "b^c"}, )" + good + "}"), "^"},
      {with(R"({"name": "a", "modifier": {"code": "1", "meaning": "b"}, )" + good + "}"), "without a type"},
  };
  for (const auto& [text, part] : cases) {
    const std::string message = refusal(text);
    EXPECT_HAS(message, part) << text;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  EXPECT_HAS(error_of([] { find_label_preset("abdomn"); }), "abdomen");
  EXPECT_HAS(error_of([&] { find_label_preset((folder / "none.json").string()); }), "none.json");
}

TEST_F(LabelPresetFiles, CodesAreInSegmentNrrdAsIn3dSlicer) {
  Scene scene;
  for (const char* name : {"Left kidney", "odd thing"}) {
    MeshItem& item = scene.meshes.emplace_back();
    item.id = item.label = static_cast<int>(scene.meshes.size());
    item.name = name;
    item.mesh = make_sphere({item.label * 10.0, 8, 8}, 4, 3);
  }
  VolumeGeometry grid;
  grid.size = {32, 16, 16};
  save_labels(folder / "a.seg.nrrd", scene, grid);
  const std::string header = test::bytes_of(folder / "a.seg.nrrd");
  EXPECT_HAS(
      header,
      "Segment0_Tags:=Segmentation.Status:inprogress|TerminologyEntry:Segmentation category and type - 3D Slicer "
      "General Anatomy list~SCT^123037004^Anatomical Structure~SCT^64033007^Kidney~SCT^7771000^Left~Anatomic "
      "codes - DICOM master list~^^~^^|\n");
  EXPECT_HAS(header, "~SCT^85756007^Tissue~SCT^85756007^Tissue~^^~Anatomic codes");
  const LoadedVolume loaded = load_volume(folder / "a.seg.nrrd");
  ASSERT_EQ(loaded.segments.size(), 2u);
  EXPECT_EQ(loaded.segments[0].code, code_of_name("Left kidney"));
  EXPECT_EQ(loaded.segments[1].code, tissue_code());
}

}  // namespace
}  // namespace simplexseg
