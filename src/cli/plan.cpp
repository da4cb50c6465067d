// SPDX-License-Identifier: Apache-2.0
#include "cli/plan.h"

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "app/load.h"
#include "app/table.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "session/run_estimate.h"
#include "session/session.h"

namespace simplexseg {
namespace {

struct PlanOptions {
  std::string scene;
  std::vector<std::string> settings;
  bool json = false;
};

void plan(const PlanOptions& options, const Console& console) {
  LoadedInput loaded = load_scene(options.scene, {.settings = options.settings, .voxels = LoadOptions::Voxels::Skip});
  const int steps = loaded.scene.steps;
  print_plan(std::move(loaded), steps, options.json, console);
}

std::string fields_text(const RunEstimate& run) {
  if (run.field_cells == 0) return "fields: none, no segmentation uses evidence from marks\n";
  return "fields: " + counted(static_cast<std::int64_t>(run.field_cells), "cell") + ", " +
         format_bytes(static_cast<double>(run.field_bytes_held)) + " of memory, and " +
         format_bytes(static_cast<double>(run.field_bytes_solving)) + " while one is solved\n";
}

}  // namespace

void print_plan(LoadedInput loaded, int steps, bool json, const Console& console) {
  Session session(make_cpu_engine());
  session.open(std::move(loaded.scene), std::move(loaded.volume));
  const StepPlan plan = make_plan(session.scene(), session.volume());
  const RunEstimate run = estimate_run(session.scene(), session.volume(), plan, steps);
  const std::optional<CudaDevice> device = cuda_device();
  print_warnings(loaded.warnings, console);
  if (json) {
    nlohmann::ordered_json text = {{"bytes_held", plan.bytes_allocated()},
                                   {"process_bytes", run.process_bytes},
                                   {"run_seconds", run.seconds},
                                   {"run_steps", run.steps},
                                   {"field_cells", run.field_cells},
                                   {"field_bytes_held", run.field_bytes_held},
                                   {"field_bytes_solving", run.field_bytes_solving},
                                   {"estimates", RunEstimate::kSource},
                                   {"items", nlohmann::ordered_json::array()}};
    if (device) text["device"] = {{"name", device->name}, {"bytes_free", device->bytes_free}};
    for (const StepPlan::Item& item : plan.items) {
      text["items"].push_back({{"name", item.name},
                               {"what", item.what},
                               {"needed", item.needed},
                               {"why", item.why},
                               {"bytes", item.bytes}});
    }
    console.out << text.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    return;
  }
  std::vector<std::vector<std::string>> rows{{"what", "name", "needed", "bytes", "why"}};
  for (const StepPlan::Item& item : plan.items) {
    rows.push_back({item.what, item.name, item.needed ? "yes" : "no",
                    item.needed ? format_bytes(static_cast<double>(item.bytes)) : "-", item.why});
  }
  print_table(console.out, rows, rows[0].size());
  console.out << "engine: " << format_bytes(static_cast<double>(plan.bytes_allocated())) << " of memory\n"
              << fields_text(run) << "run: about " << format_bytes(static_cast<double>(run.process_bytes))
              << " of memory and " << fixed_or_dash(run.seconds, run.seconds < 10 ? 1 : 0) << " s for "
              << counted(run.steps, "step") << "; " << RunEstimate::kSource << "\n";
  if (device)
    console.out << device->name << ": " << format_bytes(static_cast<double>(device->bytes_free)) << " free; the scene "
                << (plan.bytes_allocated() <= device->bytes_free ? "fits" : "does not fit and runs on the CPU") << "\n";
  else
    console.out << "the scene runs on the CPU: " << cuda_unavailable_reason() << "\n";
}

void add_plan(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "plan",
      "Lists what a step of a scene computes, its memory and the parts that are skipped, estimates the run, and checks "
      "whether the device has enough memory; reads no voxels");
  const auto options = std::make_shared<PlanOptions>();
  sub.add_option("SCENE", options->scene, "Scene file").required();
  sub.add_option("--set", options->settings, "Set a parameter: PATH=VALUE, see run").one_value_each();
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { plan(*options, console); }; });
}

}  // namespace simplexseg
