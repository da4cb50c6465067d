// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <ostream>

#include "app/load.h"
#include "app/progress.h"
#include "app/simulate.h"
#include "app/table.h"
#include "cli/commands.h"
#include "cli/study.h"
#include "core/error.h"
#include "core/number_text.h"
#include "io/picture/plot_io.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "io/scene/follow_study.h"
#include "io/scene/scene_export.h"
#include "io/scene/scene_io.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using FollowJson = nlohmann::ordered_json;

constexpr const char* kNoRegistration = "none";
constexpr const char* kToRigid = "rigid";
constexpr const char* kToAffine = "affine";
constexpr const char* kToField = "displacement";
constexpr const char* kAgreeing = "agreeing";
constexpr const char* kAll = "all";

struct FollowOptions {
  std::string scene, image, output, series;
  int volume = 1;
  std::string to, start = "centres", marks = kAgreeing, backend = "auto";
  std::vector<std::string> transforms;
  double error_mm = -1;
  int steps = -1, threads = 0;
  bool time_points = false, earlier_layer = false;
  std::string table, report, save_transform, field, curve, plot;

  std::string registration() const {
    if (!to.empty()) return to;
    if (!transforms.empty()) return kNoRegistration;
    return time_points ? kToField : kToRigid;
  }
};

void check_choices(const FollowOptions& options) {
  if (!options.transforms.empty() && options.registration() != kNoRegistration)
    throw Error("--transform", "--to requests a registration as well", "omit one of the two");
  if (!options.time_points && options.registration() == kToField &&
      options.field.empty() != options.save_transform.empty())
    throw Error("cannot write the transform",
                "a displacement field and the affine map that acts after it are two files",
                "give both --save-transform OUT.tfm and --field FIELD.nii.gz, or none");
  if (options.registration() != kToField && !options.field.empty())
    throw Error("--field", "there is no displacement field", "add --to displacement, or omit it");
  if (options.registration() == kNoRegistration && !options.save_transform.empty())
    throw Error("--save-transform", "no transform is found", "add --to, or omit it");
  for (const auto& [name, value] : {std::pair("--curve", &options.curve), std::pair("--plot", &options.plot)})
    if (!options.time_points && !value->empty())
      throw Error(name, "a single study has no curve", "add --time-points, or omit it");
  if (!options.time_points) return;
  if (!options.transforms.empty())
    throw Error("--transform", "it is not available with --time-points", "omit it; use --to");
  if (options.earlier_layer)
    throw Error("--earlier-layer", "it is not available with --time-points", "omit one of the two");
  for (const auto& [name, value] : {std::pair("--table", &options.table), std::pair("--field", &options.field),
                                    std::pair("--save-transform", &options.save_transform)})
    if (!value->empty()) throw Error(name, "it is not available with --time-points", "omit it; use --curve");
}

void check_outputs(const FollowOptions& options) {
  std::vector<fs::path> inputs{options.scene, options.image};
  inputs.insert(inputs.end(), options.transforms.begin(), options.transforms.end());
  OutputChecks checks(std::move(inputs));
  if (options.time_points) {
    checks.require_folder(options.output);
  } else {
    require_scene_name(options.output);
    checks.require_file(options.output);
  }
  if (!options.save_transform.empty()) require_transform_name(options.save_transform);
  if (!options.field.empty()) require_field_name(options.field);
  if (!options.plot.empty()) require_plot_name(options.plot);
  for (const std::string& file :
       {options.table, options.report, options.save_transform, options.field, options.curve, options.plot})
    if (!file.empty()) checks.require_file(file);
}

FollowSettings settings_of(const FollowOptions& options) {
  FollowSettings settings;
  const std::string to = options.registration();
  if (to != kNoRegistration)
    settings.kind = to == kToField    ? RegistrationKind::Displacement
                    : to == kToAffine ? RegistrationKind::Affine
                                      : RegistrationKind::Rigid;
  if (options.start == kNoRegistration) settings.start = RegistrationStart::None;
  for (const std::string& file : options.transforms) settings.transform.append(read_transform(file));
  settings.threads = options.threads;
  if (options.error_mm >= 0) settings.error_mm = options.error_mm;
  settings.marks = options.marks == kAgreeing ? CarriedMarks::Agreeing
                   : options.marks == kAll    ? CarriedMarks::All
                                              : CarriedMarks::None;
  return settings;
}

std::unique_ptr<Session> session_of(const FollowOptions& options) {
  EngineChoice choice = engine_for(options.backend, options.backend == "cuda" ? 0 : options.threads);
  auto session = std::make_unique<Session>(std::move(choice.engine), std::move(choice.make_fallback), options.threads);
  session->set_field_solver(std::move(choice.fields));
  return session;
}

FollowJson json_of(const EarlierObject& object) {
  const Eigen::Vector3d& c = object.centroid_mm;
  FollowJson json = {{"volume_ml", object.volume_ml}};
  if (object.long_mm > 0) json["long_mm"] = object.long_mm, json["short_mm"] = object.short_mm;
  json["centroid_mm"] = {c.x(), c.y(), c.z()};
  return json;
}

FollowJson rows_json(const std::vector<FollowUpRow>& rows) {
  FollowJson json = FollowJson::array();
  for (const FollowUpRow& row : rows)
    json.push_back({{"name", row.name},
                    {"locked", row.locked},
                    {"earlier", json_of(row.earlier)},
                    {"now", json_of(row.now)},
                    {"change_ml", row.change_ml()},
                    {"change_percent", row.change_percent()},
                    {"carried_ml", row.carried_ml},
                    {"shift_mm", row.shift_mm},
                    {"unregistered_shift_mm", row.unregistered_shift_mm},
                    {"dice_carried", row.dice}});
  return json;
}

void write_json(const std::string& path, const FollowJson& json) {
  write_text(path, json.dump(2, ' ', false, FollowJson::error_handler_t::replace) + "\n");
}

void print_rows(std::ostream& out, const std::vector<FollowUpRow>& rows) {
  std::vector<std::vector<std::string>> table{{"object", "before ml", "now ml", "change ml", "change %", "long mm",
                                               "now", "short mm", "now", "shift mm", "Dice"}};
  const auto axis = [](double mm) { return mm > 0 ? fixed_text(mm, 1) : std::string("-"); };
  for (const FollowUpRow& row : rows)
    table.push_back({one_line(row.name), readable(row.earlier.volume_ml, 2), readable(row.now.volume_ml, 2),
                     readable(row.change_ml(), 2), fixed_text(row.change_percent(), 1), axis(row.earlier.long_mm),
                     axis(row.now.long_mm), axis(row.earlier.short_mm), axis(row.now.short_mm),
                     fixed_text(row.shift_mm, 1), fixed_text(row.dice, 3)});
  print_table(out, table, 1);
  out << "\nshift: of the centroid, after registration\nDice: carried surface with the present one\n";
}

void save_transforms(const FollowOptions& options, const Transform& transform) {
  Transform affine;
  for (const Transform::Step& step : transform.steps()) {
    if (const auto* const field = std::get_if<DisplacementField>(&step))
      write_field(options.field, *field);
    else
      affine.append(std::get<Eigen::Affine3d>(step));
  }
  if (affine.steps().empty()) affine.append(Eigen::Affine3d::Identity());
  write_transform(options.save_transform, affine);
}

void follow_next_study(const FollowOptions& options, const FollowSettings& settings, LoadedInput input,
                       const Console& console) {
  std::vector<std::string> warnings = std::move(input.warnings);
  std::vector<FollowUpRow> rows;
  CarriedScene carried;
  {
    Progress progress(console, "following");
    NextStudy study = follow_image(input, {options.image, options.volume, options.series}, settings,
                                   options.earlier_layer, [&](double share) {
                                     Interrupt::check();
                                     progress.set(0.7 * share);
                                   });
    warnings.insert(warnings.end(), study.next.warnings.begin(), study.next.warnings.end());
    const FollowedStudy& followed = study.followed;
    carried = followed.carried;
    as_failure([&] { write_starts(options.output, carried.scene); });
    const std::unique_ptr<Session> session = session_of(options);
    session->open(carried.scene, study.next.volume);
    add_filters(*session, std::move(study.next.volumes));
    progress.set(0.7);
    if (options.steps >= 0) {
      const Advance advance = session->advance_steps(options.steps);
      if (advance.failure) warnings.push_back(*advance.failure);
    } else if (const std::string warning = settle(*session, Interrupt::check); !warning.empty()) {
      warnings.push_back(warning);
    }
    const Scene& scene = session->scene();
    rows = follow_up_rows(scene, session->volume().geometry());
    as_failure([&] {
      write_scene(options.output, scene);
      if (!options.save_transform.empty()) save_transforms(options, followed.transform);
      if (!options.table.empty()) write_text(options.table, follow_up_csv(rows));
      if (options.report.empty()) return;
      FollowJson json = {{"simplexseg_follow_up", 1},        {"earlier", options.scene},
                         {"image", options.image},           {"error_mm", followed.error_mm},
                         {"kept_marks", carried.kept_marks}, {"dropped", FollowJson::array()},
                         {"objects", rows_json(rows)}};
      for (const DroppedItem& item : carried.dropped)
        json["dropped"].push_back({{"object", item.mesh}, {"what", item.what}, {"why", item.why}});
      if (const auto& registration = followed.registration)
        json["registration"] = {{"metric_before", registration->metric_before},
                                {"metric_after", registration->metric_after}};
      write_json(options.report, json);
    });
  }
  print_warnings(warnings, console);
  for (const DroppedItem& item : carried.dropped)
    console.err << "note: " << one_line(item.mesh) << ": " << item.what << " is not carried over: " << item.why << "\n";
  print_rows(console.out, rows);
}

void follow_all_time_points(const FollowOptions& options, const FollowSettings& settings, const LoadedInput& input,
                            const Console& console) {
  FollowedTimePoints followed;
  {
    Progress progress(console, "following");
    as_failure([&] { make_folder(options.output); });
    followed = follow_time_points(
        input, options.image, settings, options.output, fs::path(options.scene).stem().string(),
        [&] { return session_of(options); },
        [&](double share) {
          Interrupt::check();
          progress.set(share);
        });
  }
  as_failure([&] {
    if (!options.curve.empty()) write_text(options.curve, curve_csv(followed.points));
    if (!options.plot.empty()) write_plot(options.plot, curve_plot(followed.points), 900, 600);
    if (options.report.empty()) return;
    FollowJson json = {{"simplexseg_time_points", 1}, {"image", options.image}, {"time_points", FollowJson::array()}};
    for (const TimePoint& point : followed.points) {
      FollowJson one = {{"time_point", point.number}};
      if (point.time_s) one["time_s"] = *point.time_s;
      one["scene"] = point.scene;
      one["objects"] = FollowJson::array();
      for (const TimePointObject& object : point.objects) {
        FollowJson measures = json_of(object.measures);
        measures["name"] = object.name;
        one["objects"].push_back(std::move(measures));
      }
      json["time_points"].push_back(std::move(one));
    }
    write_json(options.report, json);
  });
  print_warnings(input.warnings, console);
  print_warnings(followed.warnings, console);
  std::vector<std::vector<std::string>> table{{"time point", "time s"}};
  for (const TimePointObject& object : followed.points.front().objects)
    table[0].push_back(one_line(object.name) + " ml");
  for (const TimePoint& point : followed.points) {
    std::vector<std::string>& row = table.emplace_back();
    row = {std::to_string(point.number), point.time_s ? general_text(*point.time_s, 5) : "-"};
    for (const TimePointObject& object : point.objects) row.push_back(readable(object.measures.volume_ml, 2));
  }
  print_table(console.out, table, 0);
}

void follow(const FollowOptions& options, const Console& console) {
  check_choices(options);
  check_outputs(options);
  const Interrupt interrupt;
  LoadedInput input = load_with_progress(options.scene, {}, console);
  if (input.volume.empty())
    throw Error("cannot follow " + quoted(options.scene), "the scene has no volume", "use the scene of a study");
  for (const MeshItem& item : input.scene.meshes)
    if (item.mesh.positions.empty())
      throw Error("cannot follow " + quoted(options.scene), "'" + one_line(item.name) + "' has no surface yet",
                  "run the scene first: simplexseg-cli run SCENE --save SETTLED.json");
  const FollowSettings settings = settings_of(options);
  if (options.time_points)
    follow_all_time_points(options, settings, input, console);
  else
    follow_next_study(options, settings, std::move(input), console);
}

}  // namespace

void add_follow(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "follow",
      "Carries the segmentations of a scene over to the next study of the patient, or through the time points of a 4D "
      "image, and compares the measures (docs/follow-up.md)");
  const auto options = std::make_shared<FollowOptions>();
  sub.add_option("SCENE", options->scene, "Scene of the earlier study (.json), settled").required();
  sub.add_option("IMAGE", options->image, "Image or DICOM folder of the next study, or a 4D image").required();
  sub.add_option("OUT", options->output,
                 "Output: scene of the next study (.json); with --time-points the folder of the scenes")
      .required();
  sub.add_flag("--time-points", options->time_points,
               "Follow the volumes of IMAGE from that of SCENE on, in both directions");
  sub.add_option("--volume", options->volume, "Number of the volume in a 4D file or series, counted from 1")
      .within(1, kMaxVolumes)
      .show_default();
  sub.add_option("--series", options->series, "UID of a series in a DICOM folder; default: the largest series");
  sub.add_option("--to", options->to,
                 "Registration: none, rigid, affine, or a displacement field after an affine transform; default: "
                 "rigid, with --time-points displacement")
      .one_of({kNoRegistration, kToRigid, kToAffine, kToField});
  sub.add_option("--start", options->start,
                 "Start of the registration: centres (compares positions and rotations) or none (the images as they "
                 "are)")
      .one_of({"centres", kNoRegistration})
      .show_default();
  sub.add_option("--transform", options->transforms,
                 "Transform from points of the earlier image to points of IMAGE, instead of a registration (.tfm, "
                 ".txt, .mat, .h5, .nii.gz); may be repeated, in the order in which they act")
      .one_value_each()
      .not_empty();
  sub.add_option("--error", options->error_mm,
                 "Expected error of the carried surfaces (standard deviation), mm; 0: exactly as carried; default: 2 "
                 "with a displacement field, else 3, at least a voxel; 0 for time points with a displacement field")
      .within(0.0, kMaxErrorMm);
  sub.add_option("--marks", options->marks, "Marks that are carried over: agreeing (where the images agree), all, none")
      .one_of({kAgreeing, kAll, kNoRegistration})
      .show_default();
  sub.add_flag("--earlier-layer", options->earlier_layer,
               "Adds the image of SCENE as a layer of OUT, for a comparison in the window");
  sub.add_option("--steps", options->steps, "Number of steps in the next study; default: until the meshes settle")
      .within(0, 1000000);
  sub.add_option("--table", options->table, "Output: table of volumes, axes, shifts and overlap (.csv)").not_empty();
  sub.add_option("--report", options->report, "Output: the same in JSON, with what was not carried over").not_empty();
  sub.add_option("--save-transform", options->save_transform, "Output: affine transform that was found (.tfm, .txt)")
      .not_empty();
  sub.add_option("--field", options->field,
                 "Output: displacement field (.nii.gz), which acts on a point before that transform")
      .not_empty();
  sub.add_option("--curve", options->curve, "Output with --time-points: measures at each time point (.csv)")
      .not_empty();
  sub.add_option("--plot", options->plot, "Output with --time-points: volume against time (.png, .svg)").not_empty();
  sub.add_option("--backend", options->backend, "Processor for fields and meshes")
      .one_of({"auto", "cpu", "cuda"})
      .show_default();
  sub.add_option("--threads", options->threads, "CPU threads; 0: all cores").within(0, 1024).show_default();
  sub.callback([options, &action] { action = [options](const Console& console) { follow(*options, console); }; });
}

}  // namespace simplexseg
