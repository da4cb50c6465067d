// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>

#include "forces/parameters.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Parameters to share between scenes and users, stored as a JSON file with the objects `forces` and `simulation` of a
/// scene file (docs/scene-format.md).
struct Preset {
  ForceParameters forces = default_force_parameters();
  std::optional<SimulationParameters> simulation;
};
/// Reads a preset; missing parameters have their defaults. Throws Error if the file is not a preset, has an unknown
/// key, or has an invalid value.
Preset read_preset(const std::filesystem::path& path);
/// Writes a preset through a temporary file. Throws Error for a failed write.
void write_preset(const std::filesystem::path& path, const Preset& preset);

}  // namespace simplexseg
