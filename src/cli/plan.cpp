// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "cli/commands.h"
#include "cli/load.h"
#include "cli/table.h"
#include "io/files.h"
#include "session/session.h"

namespace simplexseg {
namespace {

struct Options {
  std::string scene;
  std::vector<std::string> settings;
  bool json = false;
};

void plan(const Options& options, const Console& console) {
  LoadedInput loaded =
      load_scene(options.scene, {.settings = options.settings, .voxels = LoadOptions::Voxels::LeaveOut});
  Session session(make_cpu_engine());
  session.open(std::move(loaded.scene), std::move(loaded.volume));
  const StepPlan plan = make_plan(session.scene(), session.volume());
  const std::optional<CudaDevice> device = cuda_device();
  print_warnings(loaded.warnings, console);
  if (options.json) {
    nlohmann::ordered_json json = {{"bytes_held", plan.bytes_held()}, {"items", nlohmann::ordered_json::array()}};
    if (device) json["device"] = {{"name", device->name}, {"bytes_free", device->bytes_free}};
    for (const StepPlan::Item& item : plan.items) {
      json["items"].push_back({{"name", item.name},
                               {"what", item.what},
                               {"needed", item.needed},
                               {"why", item.why},
                               {"bytes", item.bytes}});
    }
    console.out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    return;
  }
  std::vector<std::vector<std::string>> rows{{"what", "name", "needed", "bytes", "why"}};
  for (const StepPlan::Item& item : plan.items) {
    rows.push_back({item.what, item.name, item.needed ? "yes" : "left out",
                    item.needed ? in_words(static_cast<double>(item.bytes)) : "-", item.why});
  }
  print_table(console.out, rows, rows[0].size());
  console.out << "held: " << in_words(static_cast<double>(plan.bytes_held())) << "\n";
  if (device)
    console.out << device->name << ": " << in_words(static_cast<double>(device->bytes_free)) << " free, so the scene "
                << (plan.bytes_held() <= device->bytes_free ? "fits" : "does not fit, and runs on the CPU") << "\n";
  else
    console.out << "runs on the CPU: " << why_no_cuda() << "\n";
}

}  // namespace

void add_plan(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "plan",
      "What a scene's step computes and holds, what it leaves out and why, and whether the device has room for it; "
      "no voxel is read");
  const auto options = std::make_shared<Options>();
  sub.add_option("SCENE", options->scene, "Scene file").required();
  sub.add_option("--set", options->settings, "Change a parameter first: PATH=VALUE as for run").one_value_each();
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { plan(*options, console); }; });
}

}  // namespace simplexseg
