// SPDX-License-Identifier: Apache-2.0
#include "io/scene/label_preset.h"

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/scene/code_text.h"
#include "io/scene/colour_text.h"
#include "io/scene/json_input.h"
#include "io/scene/json_output.h"
#include "io/scene/label_preset_files.h"
#include "io/scene/parameter_text.h"

namespace simplexseg {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

const CodedConcept kAnatomicalStructure{"SCT", "123037004", "Anatomical Structure"};

using Words = std::multiset<std::string>;

/// Words of a name in lower case, without numbers. L, LT, R and RT become left and right.
Words name_words(const std::string& name) {
  Words words;
  std::string word;
  for (const char c : lower_ascii(name) + " ") {
    if ((c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80) {
      word += c;
    } else if (!word.empty()) {
      if (word == "l" || word == "lt") word = "left";
      if (word == "r" || word == "rt") word = "right";
      if (word.find_first_not_of("0123456789") != std::string::npos) words.insert(word);
      word.clear();
    }
  }
  return words;
}

PresetLabel read_label(const JsonInput& input) {
  input.expect_keys({"name", "synonyms", "number", "colour", "category", "type", "modifier"});
  PresetLabel label;
  label.name = input["name"].text();
  if (one_line(label.name, 200) != label.name)
    input["name"].fail("the name has a line break or more than 200 bytes", "use a short name on one line");
  for (int s = 0; input.has("synonyms") && s < input["synonyms"].size(); ++s)
    label.synonyms.push_back(input["synonyms"][s].text());
  label.label = input["number"].integer_between(1, 65535);
  label.colour = read_colour_text(input["colour"]);
  if (input.has("type")) {
    label.code.type = read_concept(input["type"]);
    label.code.category = input.has("category") ? read_concept(input["category"]) : kAnatomicalStructure;
    if (input.has("modifier")) label.code.modifier = read_concept(input["modifier"]);
  } else if (input.has("category") || input.has("modifier")) {
    input.fail("it has a category or a modifier without a type", "add the code of its type, or remove them");
  }
  if (const std::string fault = fault_of(label.code); !fault.empty()) input.fail(fault, "correct it");
  return label;
}

LabelPreset preset_of(const JsonInput& input) {
  if (!input.has("simplexseg_labels"))
    input.fail("it is not a label preset: the key 'simplexseg_labels' is missing", "choose a label preset");
  input["simplexseg_labels"].integer_between(1, 1);
  input.expect_keys({"simplexseg_labels", "title", "labels"});
  LabelPreset preset;
  preset.title = input["title"].text();
  const JsonInput labels = input["labels"];
  if (labels.size() == 0) labels.fail("it has no label", "add at least one");
  std::set<std::string> names;
  std::set<int> numbers;
  for (int l = 0; l < labels.size(); ++l) {
    PresetLabel label = read_label(labels[l]);
    if (!names.insert(lower_ascii(label.name)).second)
      labels[l]["name"].fail("two labels have the name '" + label.name + "'", "rename one");
    if (!numbers.insert(label.label).second)
      labels[l]["number"].fail("two labels have the number " + std::to_string(label.label), "change one");
    preset.labels.push_back(std::move(label));
  }
  return preset;
}

/// Structures of the presets of the program by the words of their names and synonyms.
const std::map<Words, const PresetLabel*>& labels_by_words() {
  static const std::map<Words, const PresetLabel*> labels = [] {
    std::map<Words, const PresetLabel*> map;
    for (const LabelPreset& preset : label_presets())
      for (const PresetLabel& label : preset.labels) map.emplace(name_words(label.name), &label);
    for (const LabelPreset& preset : label_presets())
      for (const PresetLabel& label : preset.labels)
        for (const std::string& synonym : label.synonyms) map.emplace(name_words(synonym), &label);
    return map;
  }();
  return labels;
}

/// Rank of a match, 0 is the best; -1 if there is none.
int rank_of(const PresetLabel& label, const std::string& typed) {
  const std::string name = lower_ascii(label.name);
  if (name.starts_with(typed)) return 0;
  std::string initials;
  bool starts = true, starts_word = false;
  for (std::size_t c = 0; c < name.size(); ++c) {
    if (starts && name[c] != ' ') {
      initials += name[c];
      starts_word = starts_word || name.compare(c, typed.size(), typed) == 0;
    }
    starts = name[c] == ' ';
  }
  if (initials.starts_with(typed)) return 1;
  if (starts_word) return 2;
  for (const std::string& synonym : label.synonyms)
    if (lower_ascii(synonym).starts_with(typed)) return 3;
  return name.find(typed) != std::string::npos ? 4 : -1;
}

}  // namespace

std::map<std::string, int> LabelPreset::by_name() const {
  std::map<std::string, int> names;
  for (const PresetLabel& label : labels) names[label.name] = label.label;
  return names;
}

const std::vector<LabelPreset>& label_presets() {
  static const std::vector<LabelPreset> presets = [] {
    std::vector<LabelPreset> read;
    for (const LabelPresetFile& file : label_preset_files()) {
      const std::string name = file.name;
      read.push_back(preset_of(JsonInput::of_text(file.text, "label preset " + name, "label preset")));
      read.back().name = name;
    }
    return read;
  }();
  return presets;
}

LabelPreset read_label_preset(const fs::path& path) {
  LabelPreset preset = preset_of(JsonInput::open(path, "label preset"));
  preset.name = fs::absolute(path).lexically_normal().string();
  return preset;
}

LabelPreset find_label_preset(const std::string& name_or_path) {
  std::vector<std::string> names;
  for (const LabelPreset& preset : label_presets()) {
    if (preset.name == name_or_path) return preset;
    names.push_back(preset.name);
  }
  std::error_code failure;
  if (name_or_path.ends_with(".json") || fs::exists(name_or_path, failure)) return read_label_preset(name_or_path);
  throw Error("cannot read the label preset", unknown_name(one_line(name_or_path, 100), names),
              "give a name that simplexseg-cli labels lists, or the path of a file");
}

std::string label_preset_text(const LabelPreset& preset) {
  // One line per label.
  Json labels = Json::array();
  std::string text =
      "{\n  \"simplexseg_labels\": 1,\n  \"title\": " + Json(preset.title).dump() + ",\n  \"labels\": [\n";
  for (std::size_t l = 0; l < preset.labels.size(); ++l) {
    const PresetLabel& label = preset.labels[l];
    Json json = {{"name", label.name}};
    if (!label.synonyms.empty()) json["synonyms"] = label.synonyms;
    json["number"] = label.label;
    json["colour"] = colour_text(label.colour);
    json.update(code_json<Json>(label.code));
    text += "    " + json.dump() + (l + 1 < preset.labels.size() ? ",\n" : "\n");
  }
  return text + "  ]\n}\n";
}

const PresetLabel* find_label(std::span<const PresetLabel> labels, const std::string& name) {
  const Words words = name_words(name);
  if (words.empty()) return nullptr;
  const auto found = std::find_if(labels.begin(), labels.end(), [&](const PresetLabel& label) {
    return name_words(label.name) == words ||
           std::any_of(label.synonyms.begin(), label.synonyms.end(),
                       [&](const std::string& synonym) { return name_words(synonym) == words; });
  });
  return found == labels.end() ? nullptr : &*found;
}

SegmentCode code_of_name(const std::string& name) {
  const auto found = labels_by_words().find(name_words(name));
  return found == labels_by_words().end() ? tissue_code() : found->second->code;
}

SegmentCode code_of(const MeshItem& item) { return item.code.empty() ? code_of_name(item.name) : item.code; }

std::vector<const PresetLabel*> matching_labels(std::span<const PresetLabel> labels, const std::string& typed) {
  std::vector<std::pair<int, const PresetLabel*>> ranked;
  std::set<std::string> names;
  for (const PresetLabel& label : labels) {
    if (!names.insert(label.name).second) continue;
    if (const int rank = rank_of(label, lower_ascii(typed)); rank >= 0) ranked.emplace_back(rank, &label);
  }
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const PresetLabel*> matches;
  matches.reserve(ranked.size());
  for (const auto& [rank, label] : ranked) matches.push_back(label);
  return matches;
}

}  // namespace simplexseg
