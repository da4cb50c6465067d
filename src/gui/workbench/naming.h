// SPDX-License-Identifier: Apache-2.0
// Names of segmentations from label presets.
#pragma once
#include <QString>
#include <string>
#include <vector>

#include "io/scene/label_preset.h"
#include "session/command.h"

namespace simplexseg {

class Workbench;

/// Structures that the user can choose as a name: those of the scene's preset first, then those of the program. If the
/// file of the scene's preset cannot be read, its names are offered without codes.
std::vector<PresetLabel> offered_labels(const Scene& scene);

/// Command that gives a mesh name, colour and codes of a structure, and by its name also the label. If another mesh has
/// the name, the new name is "NAME 2", "NAME 3" ..., and the colour stays.
EditMesh naming_command(const Scene& scene, ItemId mesh, const PresetLabel& label);
/// Command that gives a mesh a typed name: naming_command() above if the scene's preset has it, in any case. A name
/// with the words of a structure (find_label()) also sets its codes; any other name keeps the codes.
EditMesh naming_command(const Scene& scene, ItemId mesh, const std::string& typed);

/// Chooses the label preset of the scene: one of the program, a file, or none for "". Returns false, with a message, if
/// it cannot be read.
bool choose_label_preset(Workbench& workbench, const QString& name_or_path);

/// Text for tooltips: the codes of a mesh, for example "Left, Kidney (SCT 64033007)".
QString text_of_code(const SegmentCode& code);

}  // namespace simplexseg
