// SPDX-License-Identifier: Apache-2.0
#include "io/model/train_from_table.h"

#include "core/error.h"
#include "io/model/model_cases.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

// Fractions of the time of a training from many small images.
constexpr double kRead = 0.05, kRegistered = 0.6;

void add_report(const RegisteredCase& one, TrainedTable& result) {
  result.cases.push_back({one.data->name, one.data->source, one.distance_mm, one.folded});
}

OrganModel train(const TableTraining& training, const RunJobs& run, const std::function<void(double)>& progress,
                 TrainedTable& result) {
  const auto rows = static_cast<double>(training.rows.size());
  std::vector<ModelCase> cases;
  for (const TableCase& row : training.rows) {
    progress(kRead * static_cast<double>(cases.size()) / rows);
    cases.push_back(load_model_case(row, result.warnings));
  }
  TrainingSettings settings = training.settings;
  settings.scale = training.scale.value_or(scale_for(cases));
  progress(kRead);
  const RegisteredCases registered = register_cases(cases, settings, run);
  for (const RegisteredCase& one : registered.cases) add_report(one, result);
  progress(kRegistered);
  return train_model(registered, settings, run);
}

OrganModel add(const TableTraining& training, const RunJobs& run, const std::function<void(double)>& progress,
               TrainedTable& result) {
  OrganModel organ = std::move(read_model(training.add_to).organs.front());
  if (!can_grow(organ))
    throw Error("model " + quoted(training.add_to), "it does not contain the shapes of its cases",
                "train it again from its table of cases");
  for (const TableCase& row : training.rows) {
    progress(static_cast<double>(result.cases.size()) / static_cast<double>(training.rows.size()));
    const ModelCase one = load_model_case(row, result.warnings);
    AddedCase added = add_case(organ, one, training.settings.modes, run);
    add_report(added.registered, result);
    organ = std::move(added.model);
  }
  return organ;
}

}  // namespace

TrainedTable train_from_table(const TableTraining& training, const RunJobs& run,
                              const std::function<void(double)>& progress) {
  TrainedTable result;
  OrganModel organ =
      training.add_to.empty() ? train(training, run, progress, result) : add(training, run, progress, result);
  if (!training.name.empty()) organ.name = training.name;
  if (!training.modality.empty()) organ.modality = training.modality;
  result.file.organs.push_back(std::move(organ));
  progress(1);
  return result;
}

}  // namespace simplexseg
