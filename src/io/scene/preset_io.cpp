// SPDX-License-Identifier: Apache-2.0
#include "io/scene/preset_io.h"

#include <nlohmann/json.hpp>

#include "io/platform/atomic_file.h"
#include "io/scene/json_input.h"
#include "io/scene/json_output.h"
#include "io/scene/parameter_json.h"

namespace simplexseg {
using Json = nlohmann::ordered_json;

Preset read_preset(const std::filesystem::path& path) {
  const JsonInput input = JsonInput::open(path, "preset");
  if (!input.has("simplexseg_preset"))
    input.fail("it is not a preset: the key 'simplexseg_preset' is missing", "choose a preset file");
  input["simplexseg_preset"].integer_between(1, 1);
  input.expect_keys({"simplexseg_preset", "forces", "simulation"});
  Preset preset;
  if (input.has("forces")) read_forces(input["forces"], preset.forces);
  if (input.has("simulation")) {
    preset.simulation = default_simulation_parameters();
    read_simulation(input["simulation"], *preset.simulation);
  }
  return preset;
}

void write_preset(const std::filesystem::path& path, const Preset& preset) {
  Json json = {{"simplexseg_preset", 1}, {"forces", forces_json<Json>(preset.forces, nullptr)}};
  if (preset.simulation) json["simulation"] = simulation_json<Json>(*preset.simulation);
  AtomicFile file(path);
  write_bytes(file, json_text(path, json));
  file.commit();
}

}  // namespace simplexseg
