// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>
#include <thread>

#include "app/load.h"
#include "app/metric_list.h"
#include "app/progress.h"
#include "app/table.h"
#include "cli/click_picture.h"
#include "cli/commands.h"
#include "cli/mesh_subject.h"
#include "cli/reference_mask.h"
#include "cli/study.h"
#include "core/error.h"
#include "core/number_text.h"
#include "core/thread_pool.h"
#include "field/field_subject.h"
#include "field/prior_network.h"
#include "field/robot_user.h"
#include "image/transform.h"
#include "io/labels/label_file.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "io/scene/mesh_model.h"
#include "io/scene/parameter_text.h"
#include "io/scene/point_text.h"
#include "io/scene/set_by_path.h"
#include "io/volume/volume_io.h"
#include "model/model_prior.h"
#include "step/simulation_parameters.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<double, 4> kLevels{0.80, 0.85, 0.90, 0.95};

struct ClicksOptions {
  std::string image, labels, robot = "mark", backend = "cpu", json, csv, pictures, network, model;
  std::vector<double> label;
  std::vector<std::string> without, settings_of_mesh, further;
  RobotSettings settings;
  int threads = 0;
};

/// Part of the field, or of its model, that an ablation (--without) removes.
struct Part {
  const char* name;
  void (*remove)(EvidenceSettings&);
  const char* old_name = nullptr;  ///< name in earlier versions, still accepted
  void (*remove_from_model)(OrganModel&) = nullptr;
};
void keep(EvidenceSettings&) {}
constexpr std::array kParts{
    Part{"sharpness", [](EvidenceSettings& s) { s.sharpness = 0; }},
    Part{"prior", [](EvidenceSettings& s) { s.prior_weight = 0; }},
    Part{"classifier", [](EvidenceSettings& s) { s.use_appearance = false; }},
    Part{"geodesic", [](EvidenceSettings& s) { s.use_geodesic = false; }},
    Part{"random-walk", [](EvidenceSettings& s) { s.use_random_walk = false; }, "walk"},
    Part{"memory", [](EvidenceSettings& s) { s.memory = false; }},
    Part{"far-memory", [](EvidenceSettings& s) { s.far_memory = 0; }},
    Part{"open-sides", [](EvidenceSettings& s) { s.open_side = 2; }},
    Part{"far-change", [](EvidenceSettings& s) { s.far_change = 0; }},
    Part{"cut-sides", [](EvidenceSettings& s) { s.open_cut_sides = false; }},
    Part{"surface", [](EvidenceSettings& s) { s.band_half_width = 0; }},
    Part{"surface-offset", [](EvidenceSettings& s) { s.band_offset = 0; }, "lean"},
    Part{"surface-memory", [](EvidenceSettings& s) { s.temporal_weight = s.shift_weight = 0; }},
    Part{"modes", keep, nullptr, [](OrganModel& m) { m.shape.modes.resize(m.shape.modes.rows(), 0); }},
    Part{"profiles", keep, nullptr, [](OrganModel& m) { std::ranges::fill(m.profiles.whitening, 0.0f); }},
};

/// The parts with these names. Throws Error for unknown names, and for parts of a model if there is none.
std::vector<const Part*> parts_named(const std::vector<std::string>& names, bool has_model) {
  std::vector<const Part*> parts;
  for (const std::string& name : names) {
    const auto part = std::find_if(kParts.begin(), kParts.end(),
                                   [&](const Part& p) { return name == p.name || (p.old_name && name == p.old_name); });
    if (part == kParts.end()) {
      std::vector<std::string> known;
      known.reserve(kParts.size());
      for (const Part& p : kParts) known.emplace_back(p.name);
      throw Error("--without", std::string("the part ").append(unknown_name(name, known)),
                  "name one of the parts that --help lists");
    }
    if (part->remove_from_model && !has_model)
      throw Error("--without", "'" + name + "' is a part of a model, and there is none", "add --model FILE");
    parts.push_back(&*part);
  }
  return parts;
}

/// Whether a robot corrects the field, without a mesh.
bool corrects_field(const std::string& robot) {
  return robot == "mark" || robot == "stroke" || robot == "lasso" || robot == "box" || robot == "contour";
}

/// Throws Error for an option that the chosen robot does not use.
void check_robot_options(const ClicksOptions& options) {
  if (corrects_field(options.robot) && !options.settings_of_mesh.empty())
    throw Error("--set", "the robot '" + options.robot + "' corrects the field and has no mesh",
                "omit --set, or choose --robot mesh");
  if (!corrects_field(options.robot) && !options.model.empty())
    throw Error("--model", "the robot '" + options.robot + "' corrects a mesh and does not use the model",
                "omit --model, or choose --robot mark");
  if (options.robot == "none" && !(options.without.empty() && options.network.empty()))
    throw Error(options.without.empty() ? "--network" : "--without",
                "the robot 'none' corrects a mesh that has no field", "omit this option, or choose --robot mesh");
}

/// Throws Error for outputs that cannot be written.
void check_outputs(const ClicksOptions& options) {
  OutputChecks checks({options.image, options.labels, options.network});
  for (const std::string& output : {options.json, options.csv})
    if (!output.empty()) checks.require_file(output);
  if (!options.pictures.empty()) checks.require_folder(options.pictures);
}

/// Throws Error for an invalid parameter of the mesh.
void check_settings(const ClicksOptions& options) {
  Scene scene;
  scene.simulation = default_simulation_parameters();
  for (const std::string& setting : options.settings_of_mesh) set_by_path(scene, setting);
}

/// Evidence field without a mesh.
class FieldWithoutMesh : public FieldSubject<ClickSubject> {
 public:
  using FieldSubject::FieldSubject;
  void use_model(std::shared_ptr<const OrganModel> model, const Volume& image, const RunJobs& run) {
    changeable_field().set_shape_prior(shape_prior_maker(std::move(model), image, run));
  }
  void use_images(FieldImages images) { changeable_field().set_images(std::move(images)); }
  Mask field_object() const override { return field().object(); }
  bool leaks() const override { return field().report().leaks; }
  double expected_dice() const override { return field().report().expected_dice; }
  int folded() const override { return 0; }
};

/// Field and mesh after a click.
struct FieldState {
  bool leaks;
  /// Dice of the object mask of the field: expected, with the truth, with the result; NaN without a field.
  double expected_dice, dice, dice_with_result;
  int folded;  ///< number of folded vertices of the mesh
};

struct Case {
  std::string name;  ///< value of the label, or "all"
  std::vector<RobotClick> clicks;
  std::vector<FieldState> field;  ///< state after each click
};

/// Returns the number of the first click after which the Dice is at least `level`; none if there is none.
std::optional<int> clicks_to(const Case& at, double level) {
  for (std::size_t c = 0; c < at.clicks.size(); ++c)
    if (at.clicks[c].agreement.dice >= level) return static_cast<int>(c);
  return std::nullopt;
}

/// The robot's reference is not empty.
double volume_ratio(const RobotClick& click) { return click.agreement.test_mm3 / click.agreement.reference_mm3; }

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
                      {"folded", at.field[c].folded},
                      {"depth_mm", click.reach.depth_mm},
                      {"far_share", click.reach.far_share},
                      {"farthest_mm", click.reach.farthest_mm},
                      {"volume_ratio", volume_ratio(click)}});
  }
  for (const double level : kLevels) {
    const std::optional<int> needed = clicks_to(at, level);
    levels[fixed_or_dash(level, 2)] = needed ? Json(*needed) : Json(nullptr);
  }
  return {{"label", at.name}, {"clicks_to", levels}, {"clicks", clicks}};
}

/// Returns the definition of each metric of a click, by its key in JSON and CSV.
std::vector<std::pair<std::string, std::string>> definitions() {
  std::vector<std::pair<std::string, std::string>> all;
  for (const char* key : {"dice", "hd95_mm", "assd_mm"}) all.emplace_back(key, metric_of(key).definition);
  all.emplace_back("field_dice", "Dice of the object mask of the field with the truth");
  all.emplace_back("dice_with_field", "Dice of the object mask of the field with the result");
  all.emplace_back("expected_dice", "expected Dice of the object mask of the field, computed without the truth");
  all.emplace_back("folded", "vertices of the mesh whose normal is more than 90 degrees from that of a neighbour");
  all.emplace_back("depth_mm", "distance from the click to the border of the error that it corrects");
  all.emplace_back("far_share",
                   "voxels changed by the click farther than three depths from it, per voxel of the truth");
  all.emplace_back("farthest_mm", "distance from the click to the farthest voxel that it changed");
  all.emplace_back("volume_ratio", "volume of the result, divided by that of the truth");
  return all;
}

std::string csv_text(const std::vector<Case>& cases) {
  std::string text =
      "label,click,kind,x_mm,y_mm,z_mm,radius_mm,dice,hd95_mm,assd_mm,seconds,leaks,field_dice,dice_with_field,"
      "folded,expected_dice,depth_mm,far_share,farthest_mm,volume_ratio\n";
  for (const Case& at : cases) {
    for (std::size_t c = 0; c < at.clicks.size(); ++c) {
      const RobotClick& click = at.clicks[c];
      text.append(at.name).append(",").append(std::to_string(c)).append(",").append(name_of(click.mark.kind));
      for (const double x :
           {click.mark.position_mm.x(), click.mark.position_mm.y(), click.mark.position_mm.z(), click.mark.radius_mm,
            click.agreement.dice, click.agreement.hd95_mm, click.agreement.assd_mm, click.seconds})
        text.append(",").append(fixed_or_dash(x, 4));
      text += at.field[c].leaks ? ",1" : ",0";
      for (const double x : {at.field[c].dice, at.field[c].dice_with_result})
        text.append(",").append(std::isfinite(x) ? fixed_or_dash(x, 4) : "");
      text.append(",").append(std::to_string(at.field[c].folded)).append(",");
      const double expected = at.field[c].expected_dice;
      text.append(std::isfinite(expected) ? fixed_or_dash(expected, 4) : "");
      text.append(",").append(fixed_or_dash(click.reach.depth_mm, 4));
      text.append(",").append(fixed_or_dash(click.reach.far_share, 6));
      text.append(",").append(fixed_or_dash(click.reach.farthest_mm, 4));
      text.append(",").append(fixed_or_dash(volume_ratio(click), 4)).append("\n");
    }
  }
  for (const auto& [key, definition] : definitions())
    text.append("# ").append(key).append(": ").append(definition) += '\n';
  return text;
}

void print_cases(std::ostream& out, const std::vector<Case>& cases) {
  std::vector<std::vector<std::string>> rows{{"label", "seed", "3", "5", "10", "last"}};
  for (const double level : kLevels) rows[0].push_back(std::string("to ").append(fixed_or_dash(level, 2)));
  rows[0].insert(rows[0].end(), {"HD95 mm", "ASSD mm", "s per click"});
  for (const Case& at : cases) {
    const std::size_t last = at.clicks.size() - 1;
    std::vector<std::string>& row = rows.emplace_back();
    row.push_back(at.name);
    for (const std::size_t c : {std::size_t(0), std::size_t(3), std::size_t(5), std::size_t(10), last})
      row.push_back(fixed_or_dash(at.clicks[std::min(c, last)].agreement.dice, 3));
    for (const double level : kLevels) {
      const std::optional<int> needed = clicks_to(at, level);
      row.push_back(needed ? std::to_string(*needed) : "-");
    }
    double seconds = 0;
    for (const RobotClick& click : at.clicks) seconds += click.seconds;
    row.push_back(fixed_or_dash(at.clicks.back().agreement.hd95_mm, 2));
    row.push_back(fixed_or_dash(at.clicks.back().agreement.assd_mm, 2));
    row.push_back(fixed_or_dash(seconds / static_cast<double>(at.clicks.size()), 2));
  }
  print_table(out, rows, 1);
  out << "\nDice: " << metric_of("dice").definition << "\nHD95: " << metric_of("hd95_mm").definition
      << "\nASSD: " << metric_of("assd_mm").definition << "\n";
}

void clicks(const ClicksOptions& options, const Console& console) {
  check_robot_options(options);
  check_settings(options);
  check_outputs(options);
  const std::vector<const Part*> without = parts_named(options.without, !options.model.empty());
  EvidenceSettings settings;
  for (const Part* part : without) part->remove(settings);
  PriorNetworks networks;
  if (!options.network.empty()) {
    networks = PriorNetworks::parse(read_bytes(options.network));
    settings.networks = &networks;
  }
  std::shared_ptr<OrganModel> model;
  if (!options.model.empty()) {
    model = std::make_shared<OrganModel>(*load_mesh_model(options.model, {})->organ);
    for (const Part* part : without)
      if (part->remove_from_model) part->remove_from_model(*model);
  }
  const Volume image = read_volume(options.image);
  FieldImages images;
  for (const std::string& file : options.further)
    images.further.push_back(
        resample_through(read_volume(file), image.geometry(), {}, 0, std::numeric_limits<float>::quiet_NaN()));
  const int threads =
      options.threads > 0 ? options.threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  ThreadPool pool(threads);
  const RunJobs run = [&pool](int jobs, const std::function<void(int)>& job) { pool.run(jobs, job); };
  std::vector<std::optional<double>> label_values(options.label.begin(), options.label.end());
  if (label_values.empty()) label_values.push_back(std::nullopt);
  LabelFile labels(options.labels);
  for (const std::optional<double>& label : label_values)
    reference_mask(labels, label, image.geometry(), options.labels, options.image);
  print_warnings(labels.labels({.label = label_values.back()}).warnings, console);
  RobotSettings robot = options.settings;
  robot.starts_with_box = options.robot == "box";
  robot.starts_with_lasso = options.robot == "contour";
  if (options.robot == "stroke") robot.click_kind = RobotClickKind::Strokes;
  if (options.robot == "lasso") robot.click_kind = RobotClickKind::Lassos;
  if (options.robot == "mixed") robot.click_kind = RobotClickKind::Mixed;
  if (options.robot == "grab") robot.click_kind = RobotClickKind::Grabs;
  if (options.robot == "point" || options.robot == "none") robot.click_kind = RobotClickKind::Points;
  std::vector<Case> cases;
  const Interrupt interrupt;
  {
    Progress progress(console, "clicking");
    const double all = static_cast<double>(label_values.size()) * (options.settings.most_clicks + 1);
    for (const std::optional<double>& label : label_values) {
      const Mask truth = reference_mask(labels, label, image.geometry(), options.labels, options.image);
      const Mask part = largest_part(truth);
      Case& at = cases.emplace_back();
      at.name = label ? number_to_text(static_cast<float>(*label)) : "all";
      std::unique_ptr<ClickSubject> subject;
      if (corrects_field(options.robot)) {
        auto field =
            std::make_unique<FieldWithoutMesh>(image, run, settings, engine_for(options.backend, threads).fields);
        if (model) field->use_model(model, image, run);
        field->use_images(images);
        subject = std::move(field);
      } else
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
        make_folder(options.pictures);
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
                 {"local", options.settings.local},
                 {"without", options.without},
                 {"further", options.further},
                 {"backend", options.backend},
                 {"threads", threads},
                 {"metric_definitions", Json::object()},
                 {"cases", Json::array()}};
    for (const auto& [key, definition] : definitions()) json["metric_definitions"][key] = definition;
    for (const Case& at : cases) json["cases"].push_back(case_json(at));
    write_text(options.json, json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  }
  print_cases(console.out, cases);
}

}  // namespace

void add_clicks(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "clicks",
      "Simulates a user who corrects a segmentation click by click, guided by a label volume (docs/clicks.md)");
  const auto options = std::make_shared<ClicksOptions>();
  RobotSettings& settings = options->settings;
  sub.add_option("IMAGE", options->image, "Volume to segment").required();
  sub.add_option("LABELS", options->labels, "Label volume with the truth, on the grid of IMAGE").required();
  sub.add_option("--label", options->label,
                 "Label of an object; may be repeated, one object per label; default: all voxels that are not 0")
      .one_value_each();
  sub.add_option("--max", settings.most_clicks, "Largest number of clicks after the seed")
      .within(0, 1000)
      .show_default();
  sub.add_option(
         "--robot", options->robot,
         "Segmentation that is corrected, and the kind of clicks (docs/clicks.md): mark: field without a mesh, inside "
         "and outside marks; stroke: field, inside and outside strokes; lasso: field, closed contours; box: field, a "
         "box instead of a seed, then marks; contour: field, a lasso instead of a seed, then "
         "marks; mesh: mesh, inside and outside marks; point: mesh, boundary points; grab: mesh, drags of the surface; "
         "mixed: mesh, marks and drags; none: mesh without a field, boundary points")
      .one_of({"mark", "stroke", "lasso", "box", "contour", "mesh", "point", "grab", "mixed", "none"})
      .show_default();
  sub.add_flag("--local", settings.local, "Corrections change the segmentation only near them (local marks)");
  sub.add_option("--seed-scale", settings.seed_scale, "Radius of the seed, as a multiple of the correct radius")
      .within(0.05, 3.0)
      .show_default();
  sub.add_option("--seed-offset", settings.seed_offset,
                 "Offset of the centre of the seed, as a multiple of the correct radius")
      .within(0.0, 1.0)
      .show_default();
  sub.add_option(
         "--without", options->without,
         "Disable a part of the field: sharpness, prior, classifier, geodesic, random-walk, memory, far-memory, "
         "open-sides, far-change, cut-sides, surface, surface-offset or surface-memory, or of the model: modes or "
         "profiles; may be repeated; not with --robot none")
      .one_value_each();
  sub.add_option("--set", options->settings_of_mesh,
                 "Set a parameter of the mesh: simulation.PARAMETER=VALUE or forces.FORCE.PARAMETER=VALUE; not with "
                 "--robot mark")
      .one_value_each();
  sub.add_option(
         "--network", options->network,
         "File with the networks of the prior, written by scripts/learn_prior, instead of the built-in ones; not with "
         "--robot none")
      .not_empty();
  sub.add_option("--model", options->model,
                 "Model of the object (simplexseg-cli model train); with robots of the field")
      .not_empty();
  sub.add_option(
         "--further", options->further,
         "Further image of the same place, which informs the prior of the field; may be repeated; with robots of "
         "the field")
      .one_value_each();
  sub.add_option("--json", options->json, "Output file (JSON) with all clicks").not_empty();
  sub.add_option("--csv", options->csv, "Output file (CSV) with all clicks").not_empty();
  sub.add_option("--pictures", options->pictures, "Output folder for a picture of each object after the last click")
      .not_empty();
  sub.add_option("--backend", options->backend, "Processor for fields and meshes")
      .one_of({"cpu", "cuda"})
      .show_default();
  sub.add_option("--threads", options->threads, "CPU threads; 0: all cores").within(0, 1024).show_default();
  sub.callback([options, &action] { action = [options](const Console& console) { clicks(*options, console); }; });
}

}  // namespace simplexseg
