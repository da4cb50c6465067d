// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>

#include "forces/parameters.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Parameters that can be shared between scenes and users: a JSON file with the objects `forces` and `simulation` of
/// scene files (docs/scene-format.md).
struct Preset {
  ForceParameters forces = default_force_parameters();
  std::optional<SimulationParameters> simulation;
};
/// Reads a preset. Throws Error if the file is not a preset, has an unknown key, or a value is out of range.
Preset read_preset(const std::filesystem::path& path);
/// Writes a preset through a temporary file. Throws Error for a failed write.
void write_preset(const std::filesystem::path& path, const Preset& preset);

}  // namespace simplexseg
