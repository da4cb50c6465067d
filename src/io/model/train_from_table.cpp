// SPDX-License-Identifier: Apache-2.0
#include "io/model/train_from_table.h"

#include <algorithm>

#include "core/error.h"
#include "core/number_text.h"
#include "io/model/model_cases.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

// Fractions of the time of a training from many small images.
constexpr double kRead = 0.05, kRegistered = 0.6;

void add_report(const RegisteredCase& one, std::size_t organ, TrainedTable& result) {
  result.cases.push_back({one.data->name, one.data->source, one.distance_mm, one.folded, static_cast<int>(organ)});
}

std::vector<OrganModel> train(const TableTraining& training, const RunJobs& run,
                              const std::function<void(double)>& progress, TrainedTable& result) {
  const auto rows = static_cast<double>(training.rows.size());
  const std::size_t count = training.rows.empty() ? 1 : training.rows.front().organs.size();
  std::vector<std::vector<ModelCase>> cases(count);  // of each organ
  for (const TableCase& row : training.rows) {
    const auto number = static_cast<int>(&row - training.rows.data());
    progress(kRead * number / rows);
    std::vector<std::optional<ModelCase>> loaded = load_model_cases(row, number, result.warnings);
    for (std::size_t organ = 0; organ < count; ++organ)
      if (loaded[organ]) cases[organ].push_back(std::move(*loaded[organ]));
  }
  progress(kRead);
  std::vector<OrganModel> organs;
  for (std::size_t organ = 0; organ < count; ++organ) {
    const auto done = [&](double share) {
      progress(kRead + (1 - kRead) * (static_cast<double>(organ) + share) / static_cast<double>(count));
    };
    TrainingSettings settings = training.settings;
    settings.scale = training.scale.value_or(scale_for(cases[organ]));
    const RegisteredCases registered = register_cases(cases[organ], settings, run);
    for (const RegisteredCase& one : registered.cases) add_report(one, organ, result);
    done(kRegistered);
    organs.push_back(train_model(registered, settings, run));
    done(1);
  }
  return organs;
}

std::vector<OrganModel> add(const TableTraining& training, const RunJobs& run,
                            const std::function<void(double)>& progress, TrainedTable& result) {
  std::vector<OrganModel> organs = std::move(read_model(training.add_to).organs);
  const std::string name = "model " + quoted(training.add_to);
  if (!std::ranges::all_of(organs, can_grow))
    throw Error(name, "it does not contain the shapes of its cases", "train it again from its table of cases");
  int images = 0;
  for (const OrganModel& organ : organs)
    for (const TrainedCase& one : organ.cases) images = std::max(images, one.image_number + 1);
  for (const TableCase& row : training.rows) {
    if (row.organs.size() != organs.size())
      throw Error(name,
                  "it has " + counted(organs.size(), "organ", "organs") + ", but case " + row.name + " has " +
                      std::to_string(row.organs.size()),
                  "give the labels of its organs in their order, as in 2;3");
    const auto number = static_cast<int>(&row - training.rows.data());
    progress(number / static_cast<double>(training.rows.size()));
    const std::vector<std::optional<ModelCase>> loaded = load_model_cases(row, images + number, result.warnings);
    for (std::size_t organ = 0; organ < organs.size(); ++organ) {
      if (!loaded[organ]) continue;
      AddedCase added = add_case(organs[organ], *loaded[organ], training.settings.modes, run);
      add_report(added.registered, organ, result);
      organs[organ] = std::move(added.model);
    }
  }
  return organs;
}

/// Gives organs the names of the training; without any, those of several organs get names from their labels.
void name_organs(const TableTraining& training, std::vector<OrganModel>& organs) {
  std::vector<std::string> names;
  if (!training.name.empty()) names = list_entries(training.name);
  if (organs.size() == 1 && !training.name.empty()) names = {training.name};
  if (!names.empty() && names.size() != organs.size())
    throw Error("the names of the organs '" + one_line(training.name, 100) + "'",
                counted(names.size(), "name", "names") + " for " + counted(organs.size(), "organ", "organs"),
                "separate the names by ';', as in Right kidney;Left kidney");
  for (std::size_t k = 0; k < organs.size(); ++k) {
    OrganModel& organ = organs[k];
    if (!names.empty()) organ.name = names[k];
    if (!training.modality.empty()) organ.modality = training.modality;
    if (organs.size() == 1 || !organ.name.empty()) continue;
    const OrganLabels& labels = training.rows.front().organs[k];
    organ.name = parse_number(labels.label) ? "label " + labels.label
                 : !labels.label.empty()    ? labels.label
                 : !labels.labels.empty()   ? labels.labels.stem().string()
                                            : "organ " + std::to_string(k + 1);
  }
  for (std::size_t k = 0; k < organs.size(); ++k)
    for (std::size_t other = 0; other < k; ++other)
      if (organs[k].name == organs[other].name)
        throw Error("the organs of the model", "two have the name '" + one_line(organs[k].name) + "'",
                    "give them different names, separated by ';'");
}

}  // namespace

TrainedTable train_from_table(const TableTraining& training, const RunJobs& run,
                              const std::function<void(double)>& progress) {
  TrainedTable result;
  result.file.organs =
      training.add_to.empty() ? train(training, run, progress, result) : add(training, run, progress, result);
  name_organs(training, result.file.organs);
  result.file.relations = train_relations(result.file.organs);
  progress(1);
  return result;
}

}  // namespace simplexseg
