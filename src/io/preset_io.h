// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <optional>

#include "forces/parameters.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Settings that go from one scene, or one user, to another: a JSON file with the objects `forces` and `simulation` as
/// scenes have them (docs/scene-format.md).
struct Preset {
  ForceParameters forces = default_force_parameters();
  std::optional<SimulationParameters> simulation;
};
/// Throws Error for what is no preset, an unknown key, or a value out of its table's range.
Preset read_preset(const std::filesystem::path& path);
/// Whole or not at all. Throws Error.
void write_preset(const std::filesystem::path& path, const Preset& preset);

}  // namespace simplexseg
