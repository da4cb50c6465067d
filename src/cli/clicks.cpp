// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <thread>

#include "cli/click_picture.h"
#include "cli/commands.h"
#include "cli/load.h"
#include "cli/mesh_subject.h"
#include "cli/metric_list.h"
#include "cli/progress.h"
#include "cli/study.h"
#include "cli/table.h"
#include "core/error.h"
#include "core/thread_pool.h"
#include "evidence/evidence_field.h"
#include "evidence/prior_network.h"
#include "evidence/robot_user.h"
#include "io/files.h"
#include "io/parameter_text.h"
#include "io/point_text.h"
#include "io/volume_io.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<double, 4> kLevels{0.80, 0.85, 0.90, 0.95};

struct Options {
  std::string image, labels, robot = "mark", backend = "cpu", json, csv, pictures, network;
  std::vector<double> label;
  std::vector<std::string> without, settings_of_mesh;
  RobotSettings settings;
  int threads = 0;
};

/// What an ablation takes away.
struct Part {
  const char* name;
  void (*remove)(EvidenceSettings&);
};
constexpr std::array kParts{
    Part{"sharpness", [](EvidenceSettings& s) { s.sharpness = 0; }},
    Part{"prior", [](EvidenceSettings& s) { s.prior_pull = 0; }},
    Part{"classifier", [](EvidenceSettings& s) { s.hear_looks = false; }},
    Part{"geodesic", [](EvidenceSettings& s) { s.hear_ways = false; }},
    Part{"walk", [](EvidenceSettings& s) { s.hear_walk = false; }},
    Part{"memory", [](EvidenceSettings& s) { s.memory = false; }},
    Part{"far-memory", [](EvidenceSettings& s) { s.far_memory = 0; }},
    Part{"open-sides", [](EvidenceSettings& s) { s.open_side = 2; }},
    Part{"surface", [](EvidenceSettings& s) { s.surface_layer = 0; }},
    Part{"lean", [](EvidenceSettings& s) { s.surface_lean = 0; }},
    Part{"surface-memory", [](EvidenceSettings& s) { s.surface_memory = s.surface_pull = 0; }},
    Part{"brush", [](EvidenceSettings& s) { s.brush = 0; }},
};

EvidenceSettings settings_without(const std::vector<std::string>& names) {
  EvidenceSettings settings;
  for (const std::string& name : names) {
    const auto part = std::find_if(kParts.begin(), kParts.end(), [&](const Part& p) { return name == p.name; });
    if (part == kParts.end()) {
      std::vector<std::string> known;
      known.reserve(kParts.size());
      for (const Part& p : kParts) known.emplace_back(p.name);
      throw Error("--without", std::string("the part ").append(unknown_name(name, known)),
                  "give one of the parts of the field");
    }
    part->remove(settings);
  }
  return settings;
}

/// Throws Error for an option that the robot's subject does not hear.
void refuse_unheard(const Options& options) {
  if (options.robot == "mark" && !options.settings_of_mesh.empty())
    throw Error("--set", "the robot 'mark' corrects the evidence field alone, without a mesh",
                "leave it out, or give --robot mesh");
  if (options.robot == "none" && !(options.without.empty() && options.network.empty()))
    throw Error(options.without.empty() ? "--network" : "--without", "the robot 'none' corrects a mesh without a field",
                "leave it out, or give --robot mesh");
}

/// The evidence field alone.
class FieldSubject : public ClickSubject {
 public:
  FieldSubject(const Volume& image, const RunJobs& run, const EvidenceSettings& settings, const MakeBoxField& make)
      : field_(image, run, settings, make) {}
  Mask segment(std::span<const Mark> marks) override {
    field_.update(marks);
    return field_.object();
  }
  double brush_mm(MarkKind kind, const Eigen::Vector3d& mm) const override { return field_.brush_mm(kind, mm); }
  Mask field_object() const override { return field_.object(); }
  bool leaks() const override { return field_.report().leaks; }
  double expected_dice() const override { return field_.report().expected_dice; }
  int folded() const override { return 0; }

 private:
  EvidenceField field_;
};

/// The field and the mesh after a click.
struct FieldState {
  bool leaks;
  double expected_dice, dice, dice_with_result;  ///< of its object; NaN without a field
  int folded;                                    ///< vertices of the mesh
};

struct Case {
  std::string name;  ///< of the label
  std::vector<RobotClick> clicks;
  std::vector<FieldState> field;  ///< after each click
};

/// The first click after which Dice is at least `level`.
std::optional<int> clicks_to(const Case& at, double level) {
  for (std::size_t c = 0; c < at.clicks.size(); ++c)
    if (at.clicks[c].agreement.dice >= level) return static_cast<int>(c);
  return std::nullopt;
}

Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json case_json(const Case& at) {
  Json clicks = Json::array(), levels = Json::object();
  for (std::size_t c = 0; c < at.clicks.size(); ++c) {
    const RobotClick& click = at.clicks[c];
    const Eigen::Vector3d& p = click.mark.position_mm;
    clicks.push_back({{"click", c},
                      {"kind", name_of(click.mark.kind)},
                      {"position_mm", {p.x(), p.y(), p.z()}},
                      {"radius_mm", click.mark.radius_mm},
                      {"dice", click.agreement.dice},
                      {"hd95_mm", finite_or_null(click.agreement.hd95_mm)},
                      {"assd_mm", finite_or_null(click.agreement.assd_mm)},
                      {"seconds", click.seconds},
                      {"leaks", at.field[c].leaks},
                      {"expected_dice", finite_or_null(at.field[c].expected_dice)},
                      {"field_dice", finite_or_null(at.field[c].dice)},
                      {"dice_with_field", finite_or_null(at.field[c].dice_with_result)},
                      {"folded", at.field[c].folded}});
  }
  for (const double level : kLevels) {
    const std::optional<int> needed = clicks_to(at, level);
    levels[fixed(level, 2)] = needed ? Json(*needed) : Json(nullptr);
  }
  return {{"label", at.name}, {"clicks_to", levels}, {"clicks", clicks}};
}

/// What the numbers of a click mean, by their names in JSON and CSV.
std::vector<std::pair<std::string, std::string>> definitions() {
  std::vector<std::pair<std::string, std::string>> all;
  for (const char* key : {"dice", "hd95_mm", "assd_mm"}) all.emplace_back(key, metric_of(key).definition);
  all.emplace_back("field_dice", "Dice of the object that the field says with the truth");
  all.emplace_back("dice_with_field", "Dice of the object that the field says with the result");
  all.emplace_back("expected_dice", "Dice that the field expects of its object, without the truth");
  all.emplace_back("folded", "vertices of the mesh whose normal is at more than a right angle to a neighbour's");
  return all;
}

std::string csv_text(const std::vector<Case>& cases) {
  std::string text =
      "label,click,kind,x_mm,y_mm,z_mm,radius_mm,dice,hd95_mm,assd_mm,seconds,leaks,field_dice,dice_with_field,"
      "folded,expected_dice\n";
  for (const Case& at : cases) {
    for (std::size_t c = 0; c < at.clicks.size(); ++c) {
      const RobotClick& click = at.clicks[c];
      text.append(at.name).append(",").append(std::to_string(c)).append(",").append(name_of(click.mark.kind));
      for (const double x :
           {click.mark.position_mm.x(), click.mark.position_mm.y(), click.mark.position_mm.z(), click.mark.radius_mm,
            click.agreement.dice, click.agreement.hd95_mm, click.agreement.assd_mm, click.seconds})
        text.append(",").append(fixed(x, 4));
      text += at.field[c].leaks ? ",1" : ",0";
      for (const double x : {at.field[c].dice, at.field[c].dice_with_result})
        text.append(",").append(std::isfinite(x) ? fixed(x, 4) : "");
      text.append(",").append(std::to_string(at.field[c].folded)).append(",");
      const double expected = at.field[c].expected_dice;
      text.append(std::isfinite(expected) ? fixed(expected, 4) : "").append("\n");
    }
  }
  for (const auto& [key, definition] : definitions())
    text.append("# ").append(key).append(": ").append(definition) += '\n';
  return text;
}

void print_cases(std::ostream& out, const std::vector<Case>& cases) {
  std::vector<std::vector<std::string>> rows{{"label", "seed", "3", "5", "10", "last"}};
  for (const double level : kLevels) rows[0].push_back(std::string("to ").append(fixed(level, 2)));
  rows[0].insert(rows[0].end(), {"HD95 mm", "ASSD mm", "s a click"});
  for (const Case& at : cases) {
    const std::size_t last = at.clicks.size() - 1;
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(at.name);
    for (const std::size_t c : {std::size_t(0), std::size_t(3), std::size_t(5), std::size_t(10), last})
      row.push_back(fixed(at.clicks[std::min(c, last)].agreement.dice, 3));
    for (const double level : kLevels) {
      const std::optional<int> needed = clicks_to(at, level);
      row.push_back(needed ? std::to_string(*needed) : "-");
    }
    double seconds = 0;
    for (const RobotClick& click : at.clicks) seconds += click.seconds;
    row.push_back(fixed(at.clicks.back().agreement.hd95_mm, 2));
    row.push_back(fixed(at.clicks.back().agreement.assd_mm, 2));
    row.push_back(fixed(seconds / static_cast<double>(at.clicks.size()), 2));
  }
  print_table(out, rows, 1);
  out << "\nDice: " << metric_of("dice").definition << "\nHD95: " << metric_of("hd95_mm").definition
      << "\nASSD: " << metric_of("assd_mm").definition << "\n";
}

void clicks(const Options& options, const Console& console) {
  refuse_unheard(options);
  EvidenceSettings settings = settings_without(options.without);
  PriorNetworks networks;
  if (!options.network.empty()) {
    networks = PriorNetworks::parse(read_bytes(options.network));
    settings.networks = &networks;
  }
  const Volume image = read_volume(options.image), labels = read_volume(options.labels);
  if (!image.geometry().same_grid(labels.geometry())) {
    throw Error("cannot use " + quoted(options.labels) + " as the truth of " + quoted(options.image),
                "their grids (size, spacing, origin or direction) differ", "resample one onto the grid of the other");
  }
  const int threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  ThreadPool pool(threads);
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  std::vector<std::optional<double>> wanted(options.label.begin(), options.label.end());
  if (wanted.empty()) wanted.push_back(std::nullopt);
  RobotSettings robot = options.settings;
  if (options.robot == "mixed") robot.hand = RobotHand::Mixed;
  if (options.robot == "grab") robot.hand = RobotHand::Grabs;
  if (options.robot == "point" || options.robot == "none") robot.hand = RobotHand::Points;
  std::vector<Case> cases;
  const Interrupt interrupt;
  {
    Progress progress(console, "clicking");
    const double all = static_cast<double>(wanted.size()) * (options.settings.most_clicks + 1);
    for (const std::optional<double>& label : wanted) {
      Mask truth = mask_of(labels, label);
      truth.geometry = image.geometry();  // the same grid but for rounding
      const Mask part = largest_part(truth);
      Case& at = cases.emplace_back();
      at.name = label ? number_to_text(static_cast<float>(*label)) : "all";
      std::unique_ptr<ClickSubject> subject;
      if (options.robot == "mark")
        subject = std::make_unique<FieldSubject>(image, run, settings, engine_for(options.backend, threads).fields);
      else
        subject = std::make_unique<MeshSubject>(image, options.robot != "none", options.settings_of_mesh, settings,
                                                options.backend, threads);
      Mask result;
      at.clicks = run_robot(truth, *subject, robot, [&](int click, const Mask& now) {
        Interrupt::check();
        result = now;
        const Mask object = subject->field_object();
        const bool any = !object.voxels.empty();
        at.field.push_back({subject->leaks(), subject->expected_dice(), any ? dice(part, object) : NAN,
                            any ? dice(object, result) : NAN, subject->folded()});
        progress.set((static_cast<double>(cases.size() - 1) * (options.settings.most_clicks + 1) + click + 1) / all);
      });
      if (!options.pictures.empty()) {
        std::vector<Mark> marks;
        for (const RobotClick& click : at.clicks) marks.push_back(click.mark);
        std::filesystem::create_directories(options.pictures);
        const std::string stem = std::filesystem::path(options.image).stem().stem().string();
        write_picture(std::filesystem::path(options.pictures) / (stem + "-" + at.name + ".png"),
                      draw_clicks(image, part, result, subject->field_object(), marks));
      }
    }
  }
  if (!options.csv.empty()) write_text(options.csv, csv_text(cases));
  if (!options.json.empty()) {
    Json json = {{"simplexseg_clicks", 1},
                 {"image", options.image},
                 {"labels", options.labels},
                 {"robot", options.robot},
                 {"seed_scale", options.settings.seed_scale},
                 {"seed_offset", options.settings.seed_offset},
                 {"without", options.without},
                 {"backend", options.backend},
                 {"threads", threads},
                 {"metric_definitions", Json::object()},
                 {"cases", Json::array()}};
    for (const auto& [key, definition] : definitions()) json["metric_definitions"][key] = definition;
    for (const Case& at : cases) json["cases"].push_back(case_json(at));
    write_text(options.json, json.dump(2) + "\n");
  }
  print_cases(console.out, cases);
}

}  // namespace

void add_clicks(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "clicks",
      "A robot user corrects an object click by click where a label volume says it is wrong (docs/clicks.md)");
  const auto options = std::make_shared<Options>();
  RobotSettings& settings = options->settings;
  sub.add_option("IMAGE", options->image, "Volume to segment").required();
  sub.add_option("LABELS", options->labels, "Label volume that is the truth, on the same grid").required();
  sub.add_option("--label", options->label,
                 "A label, an object of its own; may be repeated; without any, every voxel that is not 0")
      .one_value_each();
  sub.add_option("--max", settings.most_clicks, "Clicks besides the seed").within(0, 1000).show_default();
  sub.add_option(
         "--robot", options->robot,
         "What is corrected with what, docs/clicks.md: mark: the evidence field alone, with inside and outside marks; "
         "mesh: a mesh, with the same; point: a mesh, with boundary points; grab: a mesh whose surface is dragged; "
         "mixed: a mesh, with both; none: a mesh "
         "without evidence, with boundary points")
      .one_of({"mark", "mesh", "point", "grab", "mixed", "none"})
      .show_default();
  sub.add_option("--seed-scale", settings.seed_scale, "Radius of the seed, in right radii")
      .within(0.05, 3.0)
      .show_default();
  sub.add_option("--seed-offset", settings.seed_offset, "The seed's centre is off the right one by so many right radii")
      .within(0.0, 1.0)
      .show_default();
  sub.add_option("--without", options->without,
                 "Leave out a part of the field: sharpness, prior, classifier, geodesic, walk, memory, far-memory, "
                 "open-sides, surface, lean, surface-memory or brush; may be repeated; not with the robot none")
      .one_value_each();
  sub.add_option(
         "--set", options->settings_of_mesh,
         "Change a parameter of the mesh first: simulation.PARAMETER=VALUE or forces.FORCE.PARAMETER=VALUE; not "
         "with the robot mark")
      .one_value_each();
  sub.add_option(
      "--network", options->network,
      "In place of the network that says what new marks change: a file of learn_prior (scripts/learn_prior); "
      "not with the robot none");
  sub.add_option("--json", options->json, "Write every click here, as JSON");
  sub.add_option("--csv", options->csv, "Write every click here, as a table");
  sub.add_option("--pictures", options->pictures,
                 "Write a picture of each object after the last click into this folder");
  sub.add_option("--backend", options->backend, "Where fields are learned and meshes move")
      .one_of({"cpu", "cuda"})
      .show_default();
  sub.add_option("--threads", options->threads, "CPU threads; 0: as many as the machine has")
      .within(0, 1024)
      .show_default();
  sub.callback([options, &action] { action = [options](const Console& console) { clicks(*options, console); }; });
}

}  // namespace simplexseg
