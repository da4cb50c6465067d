// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "field/run_jobs.h"
#include "image/mask.h"
#include "image/volume.h"
#include "model/organ_model.h"

namespace simplexseg {

struct ModelCase {
  std::string name;  ///< in messages
  Volume image;
  Mask object;  ///< on the grid of the image
  TrainedCase::Source source{};
  int image_number = 0;  ///< TrainedCase::image_number
};

struct TrainingSettings {
  int vertices = 0;  ///< approximate number of vertices of the template; 0: 1000, or more for a thin object
  int modes = 60;    ///< largest number of modes
  IntensityScale scale = IntensityScale::Percentiles;
  bool measure_curve = false;  ///< measures OrganModel::curve
};

/// Training case with the registered template.
struct RegisteredCase {
  const ModelCase* data = nullptr;
  Eigen::Matrix3Xd points;           ///< of the template's vertices, mm
  Eigen::Vector3d seed_mm{0, 0, 0};  ///< deepest place of the object
  double radius_mm = 0;              ///< its depth
  /// Mean distance to the nearest vertex, between template and surface of the object, symmetric.
  double distance_mm = 0;
  int folded = 0;  ///< folded_vertices()
};

/// Correspondence of all cases with a template, the case of median volume.
struct RegisteredCases {
  SimplexMesh mesh;  ///< template
  std::vector<RegisteredCase> cases;
};
/// Registers a template to all cases (register_template()). `cases` must outlive the result. Throws Error without a
/// case, or for an empty object.
RegisteredCases register_cases(const std::vector<ModelCase>& cases, const TrainingSettings& settings,
                               const RunJobs& run);

/// Statistics of registered cases, including the error of cases that were left out in turn:
/// OrganModel::surface_error_mm. The name is left empty.
OrganModel train_model(const RegisteredCases& registered, const TrainingSettings& settings, const RunJobs& run);

/// Whether a model contains what add_case() needs of its cases.
bool can_grow(const OrganModel& model);

/// Model with one more case.
struct AddedCase {
  OrganModel model;
  RegisteredCase registered;  ///< refers to the added case
};
/// Adds a case to a model: registers its mean shape to the case, and computes the statistics of all cases again.
/// Profiles keep the sampling of `model`. The error of `model` on the case, which it has not seen, contributes to
/// OrganModel::surface_error_mm. `most_modes`: TrainingSettings::modes. `added` must outlive the result. Throws Error
/// for an empty object, and for a model that cannot grow.
AddedCase add_case(const OrganModel& model, const ModelCase& added, int most_modes, const RunJobs& run);

}  // namespace simplexseg
