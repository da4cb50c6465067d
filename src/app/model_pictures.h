// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/picture/picture_io.h"
#include "model/organ_model.h"

namespace simplexseg {

/// Draws the mean shape of a model and the shapes at -2 and +2 deviations of a mode: columns -2, 0, +2; rows: from the
/// left of the patient, and from the front. Red: outside the mean shape, blue: inside; full colour at the largest
/// displacement of the mode. `panel`: edge of each square, pixels.
Picture draw_mode(const OrganModel& model, int mode, int panel = 260);

/// Writes mode_1.png ... of the first modes (kPicturedModes at most), variance.png, and error.png where the model has
/// errors for several numbers of cases. The folder must exist. Throws the errors of write_picture().
void write_model_pictures(const OrganModel& model, const std::filesystem::path& folder);
inline constexpr int kPicturedModes = 5;

}  // namespace simplexseg
