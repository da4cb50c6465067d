// SPDX-License-Identifier: Apache-2.0
#include "gui/workbench/naming.h"

#include <algorithm>
#include <map>

#include "core/error.h"
#include "core/number_text.h"
#include "gui/look/qt_text.h"
#include "gui/workbench/workbench.h"
#include "session/free_attributes.h"

namespace simplexseg {

std::vector<PresetLabel> offered_labels(const Scene& scene) {
  std::vector<PresetLabel> labels;
  if (!scene.labels.preset.empty()) {
    try {
      labels = find_label_preset(scene.labels.preset).labels;
    } catch (const Error&) {  // the file was moved or changed since it was chosen
      for (const auto& [name, label] : scene.labels.by_name)
        labels.push_back({.name = name, .label = label, .colour = free_colour(scene)});
    }
  }
  for (const LabelPreset& preset : label_presets())
    labels.insert(labels.end(), preset.labels.begin(), preset.labels.end());
  return labels;
}

EditMesh naming_command(const Scene& scene, ItemId mesh, const PresetLabel& label) {
  const auto used_by_other = [&](const std::string& name) {
    const MeshItem* const other = scene.find_mesh(name);
    return other && other->id != mesh;
  };
  EditMesh command{mesh, label.name, {}, {}, {}};
  for (int number = 2; used_by_other(*command.name); ++number) command.name = label.name + " " + std::to_string(number);
  if (*command.name == label.name) command.colour = label.colour;
  command.code = label.code;
  return command;
}

EditMesh naming_command(const Scene& scene, ItemId mesh, const std::string& typed) {
  const std::vector<PresetLabel> labels = offered_labels(scene);
  const auto exact = std::find_if(labels.begin(), labels.end(), [&](const PresetLabel& label) {
    return scene.labels.by_name.contains(label.name) && lower_ascii(label.name) == lower_ascii(typed);
  });
  if (exact != labels.end()) return naming_command(scene, mesh, *exact);
  EditMesh command{mesh, typed, {}, {}, {}};
  if (const PresetLabel* const label = find_label(labels, typed); label && !label->code.empty())
    command.code = label->code;
  return command;
}

bool choose_label_preset(Workbench& workbench, const QString& name_or_path) {
  if (name_or_path.isEmpty()) return workbench.apply(ChooseLabelPreset{});
  try {
    const LabelPreset preset = find_label_preset(shown_path(name_or_path));
    std::map<ItemId, int> before;
    for (const MeshItem& item : workbench.scene().meshes) before[item.id] = item.label;
    if (!workbench.apply(ChooseLabelPreset{preset.name, preset.by_name()})) return false;
    const std::vector<MeshItem>& meshes = workbench.scene().meshes;
    const auto changed = std::count_if(meshes.begin(), meshes.end(),
                                       [&](const MeshItem& item) { return item.label != before[item.id]; });
    if (changed > 0)
      workbench.notify(Severity::Note, Workbench::tr("%1: changed the labels of %2. Undo restores them.")
                                           .arg(text(preset.title), counted_text(changed, "segmentation")));
    return true;
  } catch (const std::exception& error) {
    workbench.notify(Severity::Failure, QString::fromUtf8(error.what()));
    return false;
  }
}

QString text_of_code(const SegmentCode& code) {
  if (code.empty()) return {};
  const QString meaning =
      code.modifier.empty() ? text(code.type.meaning) : text(code.modifier.meaning) + ", " + text(code.type.meaning);
  return QString("%1 (%2 %3)").arg(meaning, text(code.type.scheme), text(code.type.value));
}

}  // namespace simplexseg
