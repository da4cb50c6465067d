// SPDX-License-Identifier: Apache-2.0
#include "archive/web_json.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "archive/faults.h"
#include "io/dicom/dicom_texts.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

using PlainJson = nlohmann::json;

constexpr int kMaxNesting = 32;
constexpr std::size_t kMaxText = 200;

/// Whether brackets outside of strings are nested deeper than kMaxNesting. The parser needs memory for each level.
bool is_nested_deeply(const std::string& text) {
  int depth = 0;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (in_text && text[i] == '\\') {
      ++i;
    } else if (text[i] == '"') {
      in_text = !in_text;
    } else if (!in_text && (text[i] == '[' || text[i] == '{')) {
      if (++depth > kMaxNesting) return true;
    } else if (!in_text && (text[i] == ']' || text[i] == '}')) {
      --depth;
    }
  }
  return false;
}

PlainJson parse(const std::string& text) {
  return is_nested_deeply(text) ? PlainJson(PlainJson::value_t::discarded) : PlainJson::parse(text, nullptr, false);
}

/// Values of an attribute; null if there are none. `tag`: hexadecimal, for example "0020000D".
const PlainJson* values_of(const PlainJson& entry, const char* tag) {
  if (!entry.is_object()) return nullptr;
  const auto attribute = entry.find(tag);
  if (attribute == entry.end() || !attribute->is_object()) return nullptr;
  const auto values = attribute->find("Value");
  return values != attribute->end() && values->is_array() && !values->empty() ? &*values : nullptr;
}

std::string text_of(const PlainJson& value) {
  if (value.is_string()) return one_line(value.get<std::string>(), kMaxText);
  if (value.is_number_integer()) return std::to_string(value.get<std::int64_t>());
  if (!value.is_object()) return {};
  const auto name = value.find("Alphabetic");
  return name != value.end() && name->is_string() ? one_line(name->get<std::string>(), kMaxText) : "";
}

std::string text_of(const PlainJson& entry, const char* tag) {
  const PlainJson* const values = values_of(entry, tag);
  return values ? text_of(values->front()) : "";
}

std::string uid_of(const PlainJson& entry, const char* tag) {
  const std::string text = text_of(entry, tag);
  return is_dicom_uid(text) ? text : "";
}

int count_of(const PlainJson& entry, const char* tag, int otherwise) {
  return count_in(text_of(entry, tag), otherwise);
}

/// JSON list in a response. Some archives send an empty text for an empty list.
PlainJson list_of(const ArchiveServer& server, const std::string& text) {
  if (text.empty()) return PlainJson::array();
  PlainJson json = parse(text);
  if (!json.is_array())
    throw archive_fault(server, "its response is not DICOM JSON", "check that its URL is the one for DICOMweb");
  return json;
}

}  // namespace

std::vector<ArchiveStudy> studies_of_json(const ArchiveServer& server, const std::string& text) {
  std::vector<ArchiveStudy> studies;
  for (const PlainJson& entry : list_of(server, text)) {
    ArchiveStudy study;
    study.uid = uid_of(entry, "0020000D");
    if (study.uid.empty()) continue;
    study.patient_name = display_name(text_of(entry, "00100010"));
    study.patient_id = text_of(entry, "00100020");
    study.date = display_date(text_of(entry, "00080020"));
    study.description = text_of(entry, "00081030");
    if (const PlainJson* const modalities = values_of(entry, "00080061")) {
      for (const PlainJson& one : *modalities)
        if (std::string name = text_of(one); !name.empty() && study.modalities.size() < 20)
          study.modalities.push_back(std::move(name));
    }
    study.series = count_of(entry, "00201206", -1);
    study.instances = count_of(entry, "00201208", -1);
    studies.push_back(std::move(study));
  }
  return studies;
}

std::vector<ArchiveSeries> series_of_json(const ArchiveServer& server, const std::string& text,
                                          const std::string& study) {
  std::vector<ArchiveSeries> all;
  for (const PlainJson& entry : list_of(server, text)) {
    ArchiveSeries series;
    series.study = study;
    series.uid = uid_of(entry, "0020000E");
    if (series.uid.empty()) continue;
    series.number = count_of(entry, "00200011", 0);
    series.modality = text_of(entry, "00080060");
    series.description = text_of(entry, "0008103E");
    series.instances = count_of(entry, "00201209", -1);
    all.push_back(std::move(series));
  }
  return all;
}

std::set<std::string> instances_of_json(const ArchiveServer& server, const std::string& text) {
  std::set<std::string> uids;
  for (const PlainJson& entry : list_of(server, text))
    if (std::string uid = uid_of(entry, "00080018"); !uid.empty()) uids.insert(std::move(uid));
  return uids;
}

StoreResponse store_response_of_json(const std::string& text) {
  StoreResponse response;
  const PlainJson json = parse(text);
  if (const PlainJson* const failed = values_of(json, "00081198")) {
    response.rejected = static_cast<int>(failed->size());
    const int reason = count_of(failed->front(), "00081197", 0);
    if (reason > 0) response.reason = status_text(static_cast<unsigned>(reason));
  }
  if (const PlainJson* const stored = values_of(json, "00081199")) {
    const int reason = count_of(stored->front(), "00081196", 0);
    if (reason == 0xb000) response.warning = "the archive changed some values";
    if (reason == 0xb006) response.warning = "the archive discarded some attributes";
    if (reason == 0xb007) response.warning = "the archive reports that the data do not match their SOP class";
  }
  return response;
}

}  // namespace simplexseg
