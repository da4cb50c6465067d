// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <ostream>

#include "app/table.h"
#include "cli/commands.h"
#include "io/scene/colour_text.h"
#include "io/scene/label_preset.h"

namespace simplexseg {
namespace {

struct LabelsOptions {
  std::string preset;
  bool json = false;
};

std::string code_text_of(const SegmentCode& code) {
  if (code.empty()) return "";
  const std::string modifier = code.modifier.empty() ? "" : ", " + code.modifier.meaning;
  return code.type.scheme + " " + code.type.value + " " + code.type.meaning + modifier;
}

void list_presets(std::ostream& out) {
  std::vector<std::vector<std::string>> rows{{"preset", "labels", "title"}};
  for (const LabelPreset& preset : label_presets())
    rows.push_back({preset.name, std::to_string(preset.labels.size()), preset.title});
  print_table(out, rows, rows[0].size());
}

void print_labels(const LabelsOptions& options, const Console& console) {
  if (options.preset.empty()) return list_presets(console.out);
  const LabelPreset preset = find_label_preset(options.preset);
  if (options.json) {
    console.out << label_preset_text(preset);
    return;
  }
  std::vector<std::vector<std::string>> rows{{"label", "name", "colour", "code"}};
  for (const PresetLabel& label : preset.labels)
    rows.push_back({std::to_string(label.label), label.name, colour_text(label.colour), code_text_of(label.code)});
  print_table(console.out, rows, rows[0].size());
}

}  // namespace

void add_labels(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("labels", "Lists the label presets, or the names, labels, colours and DICOM codes of one");
  const auto options = std::make_shared<LabelsOptions>();
  sub.add_option("PRESET", options->preset, "Name of a preset, or a preset file; default: lists the presets");
  sub.add_flag("--json", options->json, "Print the preset as a file, to start your own");
  sub.callback([options, &action] { action = [options](const Console& console) { print_labels(*options, console); }; });
}

}  // namespace simplexseg
