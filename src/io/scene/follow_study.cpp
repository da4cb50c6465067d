// SPDX-License-Identifier: Apache-2.0
#include "io/scene/follow_study.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "core/number_text.h"
#include "io/mesh/mesh_io.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
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

/// Follows one scene over the volumes of an image in one direction.
class TimePointFollower {
 public:
  TimePointFollower(const fs::path& path, const std::string& series, const FollowSettings& settings,
                    const fs::path& folder, std::string name, const MakeSession& make_session,
                    const std::function<void(double)>& on_progress, int count)
      : path_(path),
        series_(series),
        settings_(settings),
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
  Scene follow(const Scene& scene, const Volume& earlier, const Volume& next, int number,
               std::vector<std::string>& warnings) {
    FollowedStudy followed = follow_study(scene, earlier, next, settings_, [this](double share) { report(share / 2); });
    const std::string point = "time point " + std::to_string(number) + ": ";
    for (const DroppedItem& dropped : followed.carried.dropped)
      warnings.push_back(point + dropped.mesh + ", " + dropped.what + " dropped: " + dropped.why);
    write_starts(scene_path(number), followed.carried.scene);
    set_image(followed.carried.scene, {path_.string(), number, series_}, next);
    const std::unique_ptr<Session> session = make_session_();
    session->open(std::move(followed.carried.scene), next);
    const std::string warning = settle(*session, [this] { report(0.5); });
    if (!warning.empty()) warnings.push_back(point + warning);
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
  const FollowSettings& settings_;
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
                                            .equalise = *settings.kind == RegistrationKind::Displacement};
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

void write_starts(const fs::path& scene_path, Scene& scene) {
  for (MeshItem& item : scene.meshes) {
    if (!item.start || !item.start->mesh || !item.start->path.empty()) continue;
    const fs::path path = fs::absolute(scene_path.parent_path() /
                                       (scene_path.stem().string() + ".carried-" + std::to_string(item.id) + ".ply"))
                              .lexically_normal();
    write_mesh(path, *item.start->mesh);
    item.start->path = path.string();
  }
}

void set_image(Scene& scene, const FollowedImage& image, const Volume& volume) {
  scene.volume_path = fs::absolute(image.path).lexically_normal().string();
  scene.volume_number = image.number;
  scene.volume_series = image.series;
  scene.volume_checksum = checksum_of(volume);
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
  TimePointFollower follower(path, series, settings, folder, name, make_session, on_progress, info.frames);
  const int first = same ? input.scene.volume_number : 1;
  Scene first_scene = input.scene;
  Volume first_volume = input.volume;
  if (!same) {
    LoadedVolume loaded = load_volume(path, 1, series);
    first_volume = std::move(loaded.volume);
    first_scene = follower.follow(input.scene, input.volume, first_volume, first, result.warnings);
  }
  result.points.push_back(follower.record(first, time_of(first), first_scene, first_volume));
  for (const int direction : {1, -1}) {
    Scene scene = first_scene;
    Volume volume = first_volume;
    for (int number = first + direction; number >= 1 && number <= info.frames; number += direction) {
      Volume next = load_volume(path, number, series).volume;
      scene = follower.follow(scene, volume, next, number, result.warnings);
      volume = std::move(next);
      result.points.push_back(follower.record(number, time_of(number), scene, volume));
    }
  }
  std::ranges::sort(result.points, {}, &TimePoint::number);
  return result;
}

}  // namespace simplexseg
