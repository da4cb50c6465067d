// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "app/table.h"
#include "cli/archive.h"

namespace simplexseg {
namespace {

using Json = nlohmann::ordered_json;

struct ArchiveFindOptions {
  ArchiveOptions archive;
  ArchiveQuery query;
  bool json = false;
};

void print(std::ostream& out, const Json& json) {
  out << json.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

std::string count_text(int count) { return count < 0 ? "?" : std::to_string(count); }
Json count_as_json(int count) { return count < 0 ? Json() : Json(count); }

void print_studies(const FoundStudies& found, bool as_json, std::ostream& out) {
  if (as_json) {
    Json json = {{"studies", Json::array()}, {"more", found.more}};
    for (const ArchiveStudy& study : found.studies)
      json["studies"].push_back({{"study", study.uid},
                                 {"patient_name", study.patient_name},
                                 {"patient_id", study.patient_id},
                                 {"date", study.date},
                                 {"description", study.description},
                                 {"modalities", study.modalities},
                                 {"series", count_as_json(study.series)},
                                 {"instances", count_as_json(study.instances)}});
    return print(out, json);
  }
  if (found.studies.empty()) {
    out << "no matching study\n";
    return;
  }
  std::vector<std::vector<std::string>> rows = {
      {"date", "patient", "id", "modalities", "description", "study", "series", "instances"}};
  for (const ArchiveStudy& study : found.studies) {
    std::string modalities;
    for (const std::string& one : study.modalities) modalities += (modalities.empty() ? "" : " ") + one;
    rows.push_back({study.date, study.patient_name, study.patient_id, modalities, study.description, study.uid,
                    count_text(study.series), count_text(study.instances)});
  }
  print_table(out, rows, 6);
  if (found.more) out << "there are more studies: refine the search or raise --most\n";
}

void print_series(const std::vector<ArchiveSeries>& all, bool as_json, std::ostream& out) {
  if (as_json) {
    Json json = {{"series", Json::array()}};
    for (const ArchiveSeries& series : all)
      json["series"].push_back({{"study", series.study},
                                {"series", series.uid},
                                {"number", series.number},
                                {"modality", series.modality},
                                {"description", series.description},
                                {"instances", count_as_json(series.instances)}});
    return print(out, json);
  }
  std::vector<std::vector<std::string>> rows = {{"modality", "description", "series", "number", "instances"}};
  for (const ArchiveSeries& series : all)
    rows.push_back(
        {series.modality, series.description, series.uid, std::to_string(series.number), count_text(series.instances)});
  print_table(out, rows, 3);
}

void find(const ArchiveFindOptions& options, const Console& console) {
  const std::unique_ptr<Archive> archive = open_archive(server_of(options.archive));
  FoundStudies studies;
  std::vector<ArchiveSeries> series;
  const bool list_series = !options.query.study.empty();
  with_archive(console, "searching", [&](const ArchiveProgress& progress) {
    if (list_series)
      series = archive->find_series(options.query.study, progress);
    else
      studies = archive->find_studies(options.query, progress);
  });
  if (list_series)
    print_series(series, options.json, console.out);
  else
    print_studies(studies, options.json, console.out);
}

}  // namespace

void add_archive_find(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("find", "Searches for studies, or lists the series of one study");
  const auto options = std::make_shared<ArchiveFindOptions>();
  ArchiveQuery& query = options->query;
  sub.add_option("STUDY", query.study, "UID of a study whose series are listed");
  sub.add_option("--patient-name", query.patient_name,
                 "Part of the patient's name, or a pattern with * and ?, in DICOM form: DOE^J*");
  sub.add_option("--patient-id", query.patient_id, "Complete patient ID, or a pattern with * and ?");
  sub.add_option("--date", query.date,
                 "Date of the study: 2024-05-31, 2024-01-01..2024-12-31, 2024-01-01.. or ..2024-12-31");
  sub.add_option("--modality", query.modality, "Modality of at least one series of the study: CT, MR");
  sub.add_option("--description", query.description, "Part of the description of the study, or a pattern with * and ?");
  sub.add_option("--most", query.max_studies, "Largest number of studies").within(1, 10000).show_default();
  add_archive_options(sub, options->archive);
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { find(*options, console); }; });
}

}  // namespace simplexseg
