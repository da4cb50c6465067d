// SPDX-License-Identifier: Apache-2.0
// Measures of objects that were carried over, compared with the earlier study, and their course over time points.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "session/plot.h"
#include "session/scene.h"

namespace simplexseg {

/// Volume, axes (object_axes()) and centroid of an object. `geometry`: grid of its image.
EarlierObject measures_of(const SimplexMesh& mesh, const VolumeGeometry& geometry);

/// Object in both studies.
struct FollowUpRow {
  std::string name;
  Colour colour;
  bool locked = false;
  EarlierObject earlier, now;
  double carried_ml = 0;             ///< volume inside the carried surface
  double shift_mm = 0;               ///< distance between the centroids of the carried and of the present surface
  double unregistered_shift_mm = 0;  ///< distance between the earlier and the present centroid, without registration
  double dice = 0;                   ///< Dice coefficient of the insides of the carried and of the present surface

  double change_ml() const { return now.volume_ml - earlier.volume_ml; }
  double change_percent() const { return 100 * change_ml() / earlier.volume_ml; }
};
/// Rows of the meshes that were carried over and have a surface. `geometry`: grid of the present image.
std::vector<FollowUpRow> follow_up_rows(const Scene& scene, const VolumeGeometry& geometry);
/// Table in CSV with one line for each row (docs/follow-up.md).
std::string follow_up_csv(const std::vector<FollowUpRow>& rows);

/// Object at one time point.
struct TimePointObject {
  std::string name;
  Colour colour;
  EarlierObject measures;
};
/// Objects at one of the volumes of a 4D image.
struct TimePoint {
  int number = 1;                ///< of the volume, from 1
  std::optional<double> time_s;  ///< none: the file states no time
  std::string scene;             ///< path of its scene
  std::vector<TimePointObject> objects;
};
/// Measures of the meshes of a scene with a surface.
std::vector<TimePointObject> objects_of(const Scene& scene, const VolumeGeometry& geometry);
/// Table in CSV with one line for each time point and object (docs/follow-up.md).
std::string curve_csv(const std::vector<TimePoint>& points);
/// Plot of volume against time in ms (below 10 s) or s, or against the number of the time point.
Plot curve_plot(const std::vector<TimePoint>& points);

}  // namespace simplexseg
