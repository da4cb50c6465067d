// SPDX-License-Identifier: Apache-2.0
// Follow-up of a segmented study: registration of the next study, carried scene, and time points of a 4D image one
// after another (docs/follow-up.md).
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/registration/registration.h"
#include "io/scene/load_input.h"
#include "session/carry_over.h"
#include "session/follow_up.h"
#include "session/session.h"

namespace simplexseg {

/// Transform with which a study is carried over.
struct FollowSettings {
  /// Transform that is found by a registration of the next study to the earlier one; none: `transform`.
  std::optional<RegistrationKind> kind{};
  RegistrationStart start = RegistrationStart::Centres;
  FieldMetric field_metric = FieldMetric::MutualInformation;
  Transform transform;  ///< from points of the earlier study to points of the next one, without a registration
  int threads = 0;
  /// CarrySettings::error_mm; none: default_error_mm(), or 0 for time points with a displacement field, whose scenes
  /// then have no marks.
  std::optional<double> error_mm{};
  CarriedMarks marks = CarriedMarks::Agreeing;
};

/// Expected error of surfaces that are carried by such a transform, mm: at least one voxel of either image.
double default_error_mm(const FollowSettings& settings, const Volume& earlier, const Volume& next);

struct FollowedStudy {
  CarriedScene carried;
  Transform transform;
  std::optional<RegistrationResult> registration;  ///< none without a registration
  double error_mm = 0;
};
/// Registers the study `next` to the study `earlier` if requested and carries the scene over. `on_progress`: completed
/// share of the registration. Throws the errors of register_images() and carry_over(), and Cancelled.
FollowedStudy follow_study(const Scene& scene, const Volume& earlier, const Volume& next,
                           const FollowSettings& settings, const std::function<void(double)>& on_progress = {});

/// Writes the surfaces from which the meshes of a carried scene start beside the file of the scene,
/// NAME.carried-ID.ply, and sets their paths. Throws the errors of write_mesh().
void write_starts(const std::filesystem::path& scene_path, Scene& scene);

/// File of the image of the next study.
struct FollowedImage {
  std::string path;
  int number = 1;      ///< of the volume in a 4D file
  std::string series;  ///< UID of the series in a DICOM folder
};
/// Next study with the scene that was carried over to it.
struct NextStudy {
  LoadedInput next;        ///< the image, and an empty scene that refers to it
  FollowedStudy followed;  ///< its scene refers to the image
};
/// Loads the next study as a user opens it (load_input()) and carries the scene of `input` over to it (follow_study()).
/// `earlier_layer`: the image of `input` becomes a layer of the new scene, which keeps its sizes: where a displacement
/// field was found, the affine part of the transform alone places it. Throws the errors of both functions, and Error if
/// `image` is a scene.
NextStudy follow_image(const LoadedInput& input, const FollowedImage& image, const FollowSettings& settings,
                       bool earlier_layer, const std::function<void(double)>& on_progress = {});

inline constexpr int kMostFollowSteps = 6000;  ///< largest number of steps of settle()
/// Runs a session until all meshes have settled, at most kMostFollowSteps steps; `check` is called between runs of
/// some steps and may throw. Returns a warning if a mesh did not settle or failed, else "".
std::string settle(Session& session, const std::function<void()>& check);

/// Course of a scene over the volumes of a 4D image.
struct FollowedTimePoints {
  std::vector<TimePoint> points;      ///< in the order of the volumes
  std::vector<std::string> warnings;  ///< one line each
};
using MakeSession = std::function<std::unique_ptr<Session>()>;
/// Carries the scene `input` to each volume of the 4D image `path`, and writes its scene into `folder` (NAME-001.json
/// ...): from the volume of the scene if its image is `path`, else from the first one, to which the scene is carried
/// before. With a registration, that volume is registered to each other one; without one, each volume is carried to its
/// neighbour. Surfaces settle if their expected error is above 0. The volumes have the filters of the first one.
/// `on_progress`: completed share. Throws Error for an image with one volume, and the errors of follow_study(), of the
/// readers, filters and writers, and Cancelled.
FollowedTimePoints follow_time_points(const LoadedInput& input, const std::filesystem::path& path,
                                      const FollowSettings& settings, const std::filesystem::path& folder,
                                      const std::string& name, const MakeSession& make_session,
                                      const std::function<void(double)>& on_progress = {});

}  // namespace simplexseg
