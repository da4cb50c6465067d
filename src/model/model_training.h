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
  OrganModel::Source source{};
};

struct TrainingSettings {
  int vertices = 0;  ///< approximate number of vertices of the template; 0: 1000, or more for a thin object
  int modes = 60;    ///< largest number of modes
  IntensityScale scale = IntensityScale::Percentiles;
};

/// Training case with the registered template.
struct RegisteredCase {
  const ModelCase* data;
  Eigen::Matrix3Xd points;  ///< of the template's vertices, mm
  Eigen::Vector3d seed_mm;  ///< deepest place of the object
  double radius_mm;         ///< its depth
  double distance_mm;  ///< mean distance to the nearest vertex, between template and surface of the object, symmetric
  int folded;          ///< folded_vertices()
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

}  // namespace simplexseg
