// SPDX-License-Identifier: Apache-2.0
// Label presets: names of structures with label, colour and DICOM codes (docs/label-presets.md).
#pragma once
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/colour.h"
#include "core/segment_code.h"
#include "session/scene.h"

namespace simplexseg {

/// Structure of a label preset.
struct PresetLabel {
  std::string name;
  std::vector<std::string> synonyms{};
  int label = 0;  ///< 1 to 65535, unique in the preset
  Colour colour{230, 160, 60};
  SegmentCode code{};
};

/// Label preset of the program or of a file.
struct LabelPreset {
  std::string name;   ///< name of a preset of the program ("abdomen"), or absolute path of the file
  std::string title;  ///< text for the user
  std::vector<PresetLabel> labels;

  /// Labels of the names, for ChooseLabelPreset.
  std::map<std::string, int> by_name() const;
};

/// Presets of the program: the files in data/labels/, compiled into it.
const std::vector<LabelPreset>& label_presets();

/// Reads a preset file. Throws Error if it is not a label preset, has an unknown key or an invalid value, if two
/// structures have the same name or label, or if DICOM cannot store a code.
LabelPreset read_label_preset(const std::filesystem::path& path);

/// Preset of the program with the name, or else the preset of the file. Throws Error if there is neither, with the
/// names of the presets, and like read_label_preset().
LabelPreset find_label_preset(const std::string& name_or_path);

/// Contents of a preset file.
std::string label_preset_text(const LabelPreset& preset);

/// Structure whose name or synonym has the same words as `name`, in any order and case; numbers in `name` are ignored,
/// L and R stand for left and right ("Left kidney 2", "kidney_left", "Kidney L"). Null: none.
const PresetLabel* find_label(std::span<const PresetLabel> labels, const std::string& name);

/// Codes of a name: those of find_label() in the presets of the program, otherwise those of tissue.
SegmentCode code_of_name(const std::string& name);

/// Codes of a mesh: those that were chosen, otherwise those of its name.
SegmentCode code_of(const MeshItem& item);

/// Structures that match a typed text, the best first: by the beginning of the name, by the initials of its words
/// ("lk": Left kidney), by the beginning of a word, by the beginning of a synonym, and by a part of the name. Case is
/// ignored. A name occurs once; the first of `labels` with it counts. All labels for an empty text.
std::vector<const PresetLabel*> matching_labels(std::span<const PresetLabel> labels, const std::string& typed);

}  // namespace simplexseg
