// SPDX-License-Identifier: Apache-2.0
#include "io/scene/follow_study.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "image/contrast_range.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/registration/filters.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_checksum.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace fs = std::filesystem;
namespace {

constexpr double kFieldErrorMm = 2;   ///< expected error of a surface carried by a displacement field
constexpr double kLinearErrorMm = 3;  ///< by a rigid or affine transform, or without one
constexpr int kStepsBetweenChecks = 20;

bool has_field(const FollowSettings& settings) {
  if (settings.kind) return *settings.kind == RegistrationKind::Displacement;
  return !settings.transform.affine().has_value();
}

std::string number_name(int number) {
  std::string digits = std::to_string(number);
  return digits.size() < 3 ? std::string(3 - digits.size(), '0') + digits : digits;
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code failure;
  return !a.empty() && fs::equivalent(a, b, failure) && !failure;
}

/// Layer with the image of the earlier study. `transform`: from its points to those of the next one.
LayerItem layer_of(const LoadedInput& earlier, const Transform& transform) {
  const Scene& scene = earlier.scene;
  LayerItem layer;
  const fs::path path(scene.volume_path);
  const std::string file = (path.has_filename() ? path : path.parent_path()).filename().string();
  layer.name = "Earlier: " + (earlier.series.empty() ? file.substr(0, file.find('.', 1)) : earlier.series);
  layer.path = scene.volume_path;
  layer.number = scene.volume_number;
  layer.series = scene.volume_series;
  layer.checksum = scene.volume_checksum;
  layer.unit = unit_after(scene.volume_preprocessing.filters, earlier.intensity_unit);
  for (const FilterStep& step : scene.volume_preprocessing.filters)
    if (step.kind == FilterKind::Uptake) layer.scale *= step.parameters.front();
  const Volume::Range range = contrast_range(earlier.volume);
  layer.window = range.max - range.min;
  layer.level = (range.max + range.min) / 2;
  Eigen::Affine3d to_next = Eigen::Affine3d::Identity();
  for (const Transform::Step& step : transform.steps())
    if (const auto* const affine = std::get_if<Eigen::Affine3d>(&step)) to_next = *affine * to_next;
  layer.transform.affine = to_next.inverse();
  return layer;
}

/// Largest id of the items of a scene.
ItemId largest_id(const Scene& scene) {
  ItemId id = 0;
  for (const MeshItem& item : scene.meshes) id = std::max(id, item.id);
  for (const UserPoint& point : scene.points) id = std::max(id, point.id);
  return id;
}

/// Volume of a 4D image after the filters, and checksum of the volume without them.
struct TimePointImage {
  Volume volume;
  std::string checksum;
};
TimePointImage load_time_point(const fs::path& path, int number, const std::string& series,
                               const std::vector<FilterStep>& filters) {
  TimePointImage image{load_volume(path, number, series).volume, ""};
  image.checksum = checksum_of(image.volume);
  for (const FilterStep& step : filters) image.volume = filter_volume(image.volume, step);
  return image;
}

/// Carries scenes to the volumes of an image.
class TimePointFollower {
 public:
  TimePointFollower(const fs::path& path, const std::string& series, const std::vector<FilterStep>& filters,
                    const fs::path& folder, std::string name, const MakeSession& make_session,
                    const std::function<void(double)>& on_progress, int count)
      : path_(path),
        series_(series),
        filters_(filters),
        folder_(folder),
        name_(std::move(name)),
        make_session_(make_session),
        on_progress_(on_progress),
        count_(count) {}

  /// Saves the scene of a time point, which has settled, and returns its measures.
  TimePoint record(int number, const std::optional<double>& time_s, const Scene& scene, const Volume& volume) {
    TimePoint point{number, time_s, scene_path(number).string(), objects_of(scene, volume.geometry())};
    write_scene(scene_path(number), scene);
    ++done_;
    report(0);
    return point;
  }

  /// Carries a scene to the volume `number`, and settles it there.
  Scene follow(const Scene& scene, const Volume& earlier, const TimePointImage& image, int number,
               const FollowSettings& settings, std::vector<std::string>& warnings) {
    FollowedStudy followed =
        follow_study(scene, earlier, image.volume, settings, [this](double share) { report(share / 2); });
    const std::string point = "time point " + std::to_string(number) + ": ";
    for (const DroppedItem& dropped : followed.carried.dropped)
      warnings.push_back(point + dropped.mesh + ", " + dropped.what + " dropped: " + dropped.why);
    write_starts(scene_path(number), followed.carried.scene);
    Scene& next = followed.carried.scene;
    next.volume_path = fs::absolute(path_).lexically_normal().string();
    next.volume_number = number;
    next.volume_series = series_;
    next.volume_checksum = image.checksum;
    next.volume_preprocessing.filters = filters_;
    const std::unique_ptr<Session> session = make_session_();
    session->open(std::move(next), image.volume);
    if (followed.error_mm > 0) {  // otherwise the carried surfaces are the result, without settling on voxels
      const std::string warning = settle(*session, [this] { report(0.5); });
      if (!warning.empty()) warnings.push_back(point + warning);
    }
    return session->scene();
  }

 private:
  fs::path scene_path(int number) const { return folder_ / (name_ + "-" + number_name(number) + ".json"); }
  void report(double share) const {
    check_cancelled();
    if (on_progress_) on_progress_(std::min(1.0, (done_ + share) / count_));
  }

  const fs::path& path_;
  const std::string& series_;
  const std::vector<FilterStep>& filters_;
  const fs::path& folder_;
  const std::string name_;
  const MakeSession& make_session_;
  const std::function<void(double)>& on_progress_;
  const int count_;
  int done_ = 0;
};

}  // namespace

double default_error_mm(const FollowSettings& settings, const Volume& earlier, const Volume& next) {
  const double voxel_mm = std::max(earlier.geometry().spacing_mm.minCoeff(), next.geometry().spacing_mm.minCoeff());
  return std::min(std::max(has_field(settings) ? kFieldErrorMm : kLinearErrorMm, voxel_mm), kMaxErrorMm);
}

FollowedStudy follow_study(const Scene& scene, const Volume& earlier, const Volume& next,
                           const FollowSettings& settings, const std::function<void(double)>& on_progress) {
  FollowedStudy followed;
  followed.transform = settings.transform;
  if (settings.kind) {
    const RegistrationSettings registration{.kind = *settings.kind,
                                            .start = settings.start,
                                            .threads = settings.threads,
                                            .equalise = *settings.kind == RegistrationKind::Displacement &&
                                                        settings.field_metric == FieldMetric::MutualInformation,
                                            .field_metric = settings.field_metric};
    followed.registration = register_images(earlier, next, registration, [&](const RegistrationProgress& state) {
      if (on_progress) on_progress(state.done);
    });
    followed.transform = followed.registration->transform;
  }
  check_cancelled();
  followed.error_mm = settings.error_mm.value_or(default_error_mm(settings, earlier, next));
  followed.carried = carry_over(scene, earlier, next, followed.transform, {followed.error_mm, settings.marks});
  return followed;
}

NextStudy follow_image(const LoadedInput& input, const FollowedImage& image, const FollowSettings& settings,
                       bool earlier_layer, const std::function<void(double)>& on_progress) {
  if (extension_of(image.path) == ".json")
    throw Error("cannot carry over to " + quoted(image.path), "it is a scene", "choose the image of the next study");
  NextStudy study;
  study.next = load_input(image.path, image.number, image.series);
  study.followed = follow_study(input.scene, input.volume, study.next.volume, settings, on_progress);
  Scene& scene = study.followed.carried.scene;
  const Scene& opened = study.next.scene;
  scene.volume_path = opened.volume_path;
  scene.volume_number = opened.volume_number;
  scene.volume_series = opened.volume_series;
  scene.volume_checksum = opened.volume_checksum;
  scene.volume_preprocessing = opened.volume_preprocessing;
  if (earlier_layer && !input.scene.volume_path.empty()) {
    scene.layers.push_back(layer_of(input, study.followed.transform));
    scene.layers.back().id = largest_id(scene) + 1;
  }
  return study;
}

void write_starts(const fs::path& scene_path, Scene& scene) {
  for (MeshItem& item : scene.meshes) {
    if (!item.start || !item.start->mesh || !item.start->path.empty() || item.start->network) continue;
    const fs::path path = fs::absolute(scene_path.parent_path() /
                                       (scene_path.stem().string() + ".carried-" + std::to_string(item.id) + ".ply"))
                              .lexically_normal();
    write_mesh(path, *item.start->mesh);
    item.start->path = path.string();
  }
}

std::string settle(Session& session, const std::function<void()>& check) {
  Advance total;
  while (total.steps < kMostFollowSteps && !total.at_rest && !total.failure) {
    if (check) check();
    append(total, session.advance_steps(kStepsBetweenChecks, true));
  }
  if (total.failure) return *total.failure;
  return total.at_rest ? "" : "not settled after " + counted(total.steps, "step");
}

FollowedTimePoints follow_time_points(const LoadedInput& input, const fs::path& path, const FollowSettings& settings,
                                      const fs::path& folder, const std::string& name, const MakeSession& make_session,
                                      const std::function<void(double)>& on_progress) {
  const bool same = is_same_file(input.volume_path, path);
  const std::string series = same ? input.scene.volume_series : "";
  const VolumeInfo info = read_volume_info(path, same ? input.scene.volume_number : 1, series);
  if (info.frames < 2)
    throw Error("cannot follow time points in " + quoted(path), "it contains one volume",
                "choose a 4D file or series, or carry over to it as the next study");
  const auto time_of = [&](int number) {
    const auto at = static_cast<std::size_t>(number - 1);
    return at < info.times_s.size() ? std::optional(info.times_s[at]) : std::nullopt;
  };
  FollowedTimePoints result;
  // Volumes of one series have equal values for equal tissue, and about the same positions.
  FollowSettings between = settings;
  between.transform = {};
  // A field between such images is more accurate than a surface that settles again (docs/results/follow-up.md).
  if (!between.error_mm && between.kind == RegistrationKind::Displacement)
    between.error_mm = 0, between.marks = CarriedMarks::None;
  const std::vector<FilterStep> filters = (same ? input.scene : load_input(path, 1).scene).volume_preprocessing.filters;
  between.start = RegistrationStart::None;
  between.field_metric = FieldMetric::SquaredDifferences;
  TimePointFollower follower(path, series, filters, folder, name, make_session, on_progress, info.frames);
  const int first = same ? input.scene.volume_number : 1;
  Scene first_scene = input.scene;
  Volume first_volume = input.volume;
  if (!same) {
    const TimePointImage image = load_time_point(path, first, series, filters);
    first_volume = image.volume;
    first_scene = follower.follow(input.scene, input.volume, image, first, settings, result.warnings);
  }
  result.points.push_back(follower.record(first, time_of(first), first_scene, first_volume));
  for (const int direction : {1, -1}) {
    Scene scene = first_scene;
    Volume volume = first_volume;
    for (int number = first + direction; number >= 1 && number <= info.frames; number += direction) {
      const TimePointImage next = load_time_point(path, number, series, filters);
      // A registration of each volume to the first one does not add up errors; without one, neighbours agree best.
      scene = settings.kind ? follower.follow(first_scene, first_volume, next, number, between, result.warnings)
                            : follower.follow(scene, volume, next, number, between, result.warnings);
      result.points.push_back(follower.record(number, time_of(number), scene, next.volume));
      volume = next.volume;
    }
  }
  std::ranges::sort(result.points, {}, &TimePoint::number);
  return result;
}

}  // namespace simplexseg
