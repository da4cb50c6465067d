// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "io/model/case_table.h"
#include "io/model/model_file.h"
#include "model/model_training.h"

namespace simplexseg {

/// Training of a model from a table.
struct TableTraining {
  std::vector<TableCase> rows;
  TrainingSettings settings;
  std::optional<IntensityScale> scale;  ///< nothing: scale_for()
  /// Name of the organ (of several: a list separated by ';') and modality of the images; "": those of the model to
  /// which cases are added, or from the labels.
  std::string name, modality;
  /// Model to which the cases are added, in their order; "": none. It determines vertices and scale.
  std::filesystem::path add_to;
};

/// Trained case in reports.
struct CaseReport {
  std::string name;
  TrainedCase::Source source;
  double distance_mm = 0;  ///< RegisteredCase::distance_mm
  int folded = 0;          ///< RegisteredCase::folded
  int organ = 0;           ///< index in ModelFile::organs
};
struct TrainedTable {
  ModelFile file;
  std::vector<CaseReport> cases;  ///< of the first organ in the order of the table, then of the next one
  std::vector<std::string> warnings;
};

/// Trains a model from the cases of a table, or adds them to a model. `progress` receives the completed fraction, and
/// may throw to cancel. Throws the errors of load_model_cases(), read_model() and register_cases(), and Error for a
/// model that cannot grow (can_grow()), and wrong numbers of organs or names.
TrainedTable train_from_table(const TableTraining& training, const RunJobs& run,
                              const std::function<void(double)>& progress);

}  // namespace simplexseg
