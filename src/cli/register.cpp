// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <optional>
#include <ostream>

#include "app/load.h"
#include "app/progress.h"
#include "app/registration_report.h"
#include "app/simulate.h"
#include "cli/commands.h"
#include "core/error.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"
#include "io/registration/registration.h"
#include "io/transform/landmarks.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

constexpr const char* kInformation = "mutual-information";
constexpr const char* kSquares = "squared-differences";
constexpr const char* kRigid = "rigid";
constexpr const char* kAffine = "affine";
constexpr const char* kDisplacement = "displacement";
constexpr const char* kCentres = "centres";
constexpr const char* kNone = "none";

struct RegisterOptions {
  std::string fixed, moving, output;
  std::string to = kRigid, start = kCentres;
  std::string landmarks, warped, field, report;
  int threads = 0;
  bool equalise = false;
  std::string field_metric = kInformation;

  bool has_field() const { return to == kDisplacement; }
  bool starts_from_file() const { return start != kCentres && start != kNone; }
};

RegistrationKind kind_of(const std::string& name) {
  if (name == kDisplacement) return RegistrationKind::Displacement;
  return name == kAffine ? RegistrationKind::Affine : RegistrationKind::Rigid;
}

void check_outputs(const RegisterOptions& options) {
  OutputChecks checks({options.fixed, options.moving, options.landmarks});
  if (options.starts_from_file()) checks.add_input(options.start);
  require_transform_name(options.output);
  checks.require_file(options.output);
  if (!options.warped.empty()) {
    require_volume_name(options.warped);
    checks.require_file(options.warped);
  }
  if (!options.field.empty()) {
    require_field_name(options.field);
    checks.require_file(options.field);
  }
  if (!options.report.empty()) checks.require_file(options.report);
  if (options.has_field() && options.field.empty())
    throw Error("cannot register to a displacement field", "no file for it is named", "add --field FIELD.nii.gz");
  if (!options.has_field() && !options.field.empty())
    throw Error("cannot write " + quoted(options.field), "a registration to " + options.to + " has no field",
                "omit --field, or add --to displacement");
}

/// Writes the field and the affine part, which acts after it.
void write_transforms(const RegisterOptions& options, const Transform& transform) {
  Transform affine;
  for (const Transform::Step& step : transform.steps()) {
    if (const auto* const field = std::get_if<DisplacementField>(&step)) {
      write_field(options.field, *field);
    } else {
      affine.append(std::get<Eigen::Affine3d>(step));
    }
  }
  if (affine.steps().empty()) affine.append(Eigen::Affine3d::Identity());
  write_transform(options.output, affine);
}

void register_files(const RegisterOptions& options, const Console& console) {
  check_outputs(options);
  RegistrationSettings settings{.kind = kind_of(options.to),
                                .start = options.start == kNone ? RegistrationStart::None : RegistrationStart::Centres,
                                .threads = options.threads,
                                .equalise = options.equalise,
                                .field_metric = options.field_metric == kSquares ? FieldMetric::SquaredDifferences
                                                                                 : FieldMetric::MutualInformation};
  std::optional<Landmarks> landmarks;
  if (!options.landmarks.empty()) {
    landmarks = read_landmarks(options.landmarks);
    settings.initial = rigid_from_landmarks(landmarks->fixed, landmarks->moving);
  }
  if (options.starts_from_file()) {
    settings.initial = read_transform(options.start).affine();
    if (!settings.initial)
      throw Error("cannot start from " + quoted(options.start), "it is a displacement field",
                  "start from an affine transform");
  }
  RegistrationReport report{
      .fixed = options.fixed, .moving = options.moving, .result = {}, .jacobian = {}, .landmark_residuals = {}};
  std::vector<std::string> warnings;
  {
    const Interrupt interrupt;
    Progress progress(console, "registering");
    const auto load = [&](const std::string& path) {
      LoadedVolume loaded = load_volume(path);
      warnings.insert(warnings.end(), loaded.warnings.begin(), loaded.warnings.end());
      return std::move(loaded.volume);
    };
    const Volume fixed = load(options.fixed), moving = load(options.moving);
    const double start = seconds_now();
    report.result = register_images(fixed, moving, settings, [&](const RegistrationProgress& state) {
      Interrupt::check();
      progress.set(state.done);
    });
    report.seconds = seconds_now() - start;
    const Transform& transform = report.result.transform;
    report.jacobian = jacobian_range(transform, fixed.geometry());
    if (landmarks) report.landmark_residuals = residuals_mm(transform, *landmarks);
    as_failure([&] {
      write_transforms(options, transform);
      if (!options.warped.empty()) {
        const std::string warning =
            write_volume(options.warped, resample_through(moving, fixed.geometry(), transform, options.threads));
        if (!warning.empty()) warnings.push_back(warning);
      }
      if (!options.report.empty()) write_report(options.report, report);
    });
  }
  print_warnings(warnings, console);
  print_report(console.out, report);
}

}  // namespace

void add_register(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "register",
      "Registers a moving image to a fixed image by mutual information (ITK), and writes the transform from points of "
      "FIXED to points of MOVING");
  const auto options = std::make_shared<RegisterOptions>();
  sub.add_option("FIXED", options->fixed, "Image or DICOM folder onto which the other is registered").required();
  sub.add_option("MOVING", options->moving, "Image or DICOM folder that is registered").required();
  sub.add_option("OUT", options->output, "Output: transform of ITK (.tfm, .txt)").required();
  sub.add_option("--to", options->to, "Transform: rigid, affine, or a field after an affine transform")
      .one_of({kRigid, kAffine, kDisplacement})
      .show_default();
  const Option start =
      sub.add_option("--start", options->start,
                     "Start: centres (compares positions and rotations), none (the images as they are), or a transform "
                     "file (.tfm, .txt, .mat)")
          .not_empty()
          .show_default();
  sub.add_flag("--equalise", options->equalise, "Equalise the histograms of both images before, for soft tissue in CT");
  sub.add_option("--field-metric", options->field_metric,
                 "What a displacement field makes agree: mutual-information, or squared-differences for images of one "
                 "scanner and sequence, such as time points")
      .one_of({kInformation, kSquares})
      .show_default();
  sub.add_option("--landmarks", options->landmarks,
                 "Start from landmarks: a table (.csv) with x, y, z in FIXED and x, y, z in MOVING in each row, mm LPS")
      .not_empty()
      .excludes(start);
  sub.add_option("--warped", options->warped, "Output: MOVING on the grid of FIXED").not_empty();
  sub.add_option("--field", options->field,
                 "Output: displacement field (.nii.gz), which acts on a point before the transform OUT")
      .not_empty();
  sub.add_option("--report", options->report, "Output: report (.json)").not_empty();
  sub.add_option("--threads", options->threads, "Threads; 0 for all cores. The result does not depend on them")
      .within(0, 1024)
      .show_default();
  sub.callback(
      [options, &action] { action = [options](const Console& console) { register_files(*options, console); }; });
}

}  // namespace simplexseg
