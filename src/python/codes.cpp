// SPDX-License-Identifier: Apache-2.0
// Label presets and DICOM codes.
#include "python/codes.h"

#include "core/error.h"
#include "io/scene/label_preset.h"
#include "python/bindings.h"
#include "python/messages.h"

namespace simplexseg::python {
namespace {

py::tuple concept_tuple(const CodedConcept& one) {
  return py::make_tuple(python_text(one.scheme), python_text(one.value), python_text(one.meaning));
}

py::list preset_names() {
  py::list names;
  for (const LabelPreset& preset : label_presets()) names.append(python_text(preset.name));
  return names;
}

py::dict preset_labels(const py::str& name_or_path) {
  py::dict labels;
  for (const PresetLabel& label : find_label_preset(name_or_path.cast<std::string>()).labels) {
    py::dict entry;
    entry["label"] = label.label;
    entry["colour"] = py::make_tuple(label.colour.red, label.colour.green, label.colour.blue);
    entry["code"] = label.code.empty() ? py::object(py::none()) : py::object(code_dict(label.code));
    labels[python_text(label.name)] = entry;
  }
  return labels;
}

}  // namespace

py::dict code_dict(const SegmentCode& code) {
  py::dict dict;
  dict["category"] = concept_tuple(code.category);
  dict["type"] = concept_tuple(code.type);
  if (!code.modifier.empty()) dict["modifier"] = concept_tuple(code.modifier);
  return dict;
}

SegmentCode code_of_python(const py::object& code) {
  const char* const remedy = "give {'category': (scheme, value, meaning), 'type': ..., 'modifier': ...} or {}";
  SegmentCode result;
  if (!py::isinstance<py::dict>(code)) throw Error("code", "it is not a dictionary", remedy);
  for (const auto& [key, value] : code.cast<py::dict>()) {
    const std::string name = py::str(key);
    CodedConcept* const part = name == "category"   ? &result.category
                               : name == "type"     ? &result.type
                               : name == "modifier" ? &result.modifier
                                                    : nullptr;
    if (!part) throw Error("code", "it has the unknown key '" + name + "'", remedy);
    if (!py::isinstance<py::sequence>(value) || py::len(value) != 3)
      throw Error("code", "its " + name + " is not (scheme, value, meaning)", remedy);
    const auto parts = value.cast<py::sequence>();
    *part = {py::str(parts[0]), py::str(parts[1]), py::str(parts[2])};
  }
  if (py::len(code) == 0) return {};
  if (result.empty()) throw Error("code", "it has no type", remedy);
  return result;
}

void bind_label_presets(py::module_& module) {
  module.def("label_presets", &preset_names, "Names of the label presets of the program.");
  module.def("read_label_preset", &preset_labels, py::arg("preset"),
             "Reads a label preset: a name of label_presets() or a file. Returns, by name, label, colour and code, as\n"
             "SceneMesh has them. Raises Error if there is no such preset or the file is damaged.");
}

}  // namespace simplexseg::python
