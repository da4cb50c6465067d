// SPDX-License-Identifier: Apache-2.0
// An archive over DICOMweb: QIDO-RS, WADO-RS, STOW-RS (PS3.18, 10).
#include <cstring>
#include <fstream>
#include <optional>

#include "archive/faults.h"
#include "archive/http_client.h"
#include "archive/implementations.h"
#include "archive/match.h"
#include "archive/multipart.h"
#include "archive/outgoing.h"
#include "archive/receiver.h"
#include "archive/web_json.h"
#include "io/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr const char* kJson = "application/dicom+json";
constexpr const char* kParts = "multipart/related; type=\"application/dicom\"; transfer-syntax=*";
constexpr std::size_t kPage = 1000;             ///< instances that are asked for at once
constexpr std::size_t kMostInstances = 100000;  ///< of a series
constexpr const char* kBoundary = "simplexseg-5c7e2f90d14b4a63";

std::string query_of(const ArchiveQuery& query) {
  std::string text = "/studies?limit=" + std::to_string(query.most + 1);
  for (const auto& [key, value] :
       {std::pair("PatientName", part_pattern(query.patient_name)), std::pair("PatientID", query.patient_id),
        std::pair("StudyDate", dicom_date_range(query.date)), std::pair("ModalitiesInStudy", query.modality),
        std::pair("StudyDescription", part_pattern(query.description)), std::pair("StudyInstanceUID", query.study)})
    if (!value.empty()) text.append("&").append(key).append("=").append(url_escaped(value));
  for (const char* tag : {"00081030", "00080061", "00201206", "00201208"}) text.append("&includefield=").append(tag);
  return text;
}

/// A file between the lines that make it a part of a request.
class PartSource {
 public:
  explicit PartSource(const fs::path& file)
      : before_(std::string("--") + kBoundary + "\r\nContent-Type: application/dicom\r\n\r\n"),
        after_(std::string("\r\n--") + kBoundary + "--\r\n"),
        stream_(file, std::ios::binary),
        length_(fs::file_size(file)) {}
  std::uint64_t length() const { return before_.size() + length_ + after_.size(); }

  /// Fewer bytes than were promised end the request.
  std::size_t read(char* to, std::size_t most) {
    if (std::size_t count = take(before_, to, most)) return count;
    if (stream_) {
      stream_.read(to, static_cast<std::streamsize>(std::min<std::uint64_t>(most, length_ - sent_)));
      const auto count = static_cast<std::size_t>(stream_.gcount());
      sent_ += count;
      if (count > 0) return count;
    }
    return sent_ == length_ ? take(after_, to, most) : 0;
  }

 private:
  static std::size_t take(std::string& from, char* to, std::size_t most) {
    const std::size_t count = std::min(most, from.size());
    std::memcpy(to, from.data(), count);
    from.erase(0, count);
    return count;
  }
  std::string before_, after_;
  std::ifstream stream_;
  std::uint64_t length_, sent_ = 0;
};

class WebArchive : public Archive {
 public:
  explicit WebArchive(ArchiveServer server) : server_(std::move(server)) {}

  void check(const ArchiveProgress& progress) override { ask("/studies?limit=1", "DICOMweb at its URL", progress); }

  FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress) override {
    require_query(query);
    FoundStudies found;
    found.studies = studies_of_json(server_, ask(query_of(query), "DICOMweb at its URL", progress));
    sort_studies(found, query.most);
    return found;
  }

  std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress) override {
    require_uid(study, "study");
    const std::string path = "/studies/" + study + "/series?includefield=0008103E&includefield=00201209";
    std::vector<ArchiveSeries> series = series_of_json(server_, ask(path, "such study", progress), study);
    if (series.empty()) throw nothing_there(server_, "such study");
    sort_series(series);
    return series;
  }

  fs::path fetch(const std::string& study, const std::string& series, const ArchiveCache& cache,
                 const ArchiveProgress& progress) override {
    require_uid(study, "study"), require_uid(series, "series");
    const std::string path = "/studies/" + study + "/series/" + series;
    const std::set<std::string> expected = instances_of(path, progress);
    if (expected.empty()) throw nothing_there(server_, "such series");
    if (const auto kept = cache.find(server_, series, expected)) return *kept;
    SeriesReceiver receiver(server_, cache, series, expected, progress);
    receive(path, receiver);
    return receiver.finish();
  }

  ArchiveSent send(const std::vector<fs::path>& files, const ArchiveProgress& progress) override {
    Outgoing outgoing(server_, files, progress);
    const HttpClient http(server_);
    for (const Outgoing::Instance& instance : outgoing.instances())
      outgoing.guard([&] { store(http, instance.file, outgoing); });
    return outgoing.sent();
  }

 private:
  /// The body of a small answer; empty where there is nothing (204).
  std::string ask(const std::string& path, const std::string& what, const ArchiveProgress& progress) const {
    const HttpClient http(server_);
    HttpAnswer answer = http.get(path, kJson, [&] { tell(progress, {}); });
    http.require_ok(answer, what);
    return std::move(answer.body);
  }

  /// Archives may give fewer than they are asked for: until no further ones come.
  std::set<std::string> instances_of(const std::string& path, const ArchiveProgress& progress) const {
    std::set<std::string> all;
    for (std::size_t before = 0; all.size() < kMostInstances; before = all.size()) {
      const std::string page = path + "/instances?limit=" + std::to_string(kPage) + "&offset=" + std::to_string(before);
      all.merge(instances_of_json(server_, ask(page, "such series", progress)));
      if (all.size() == before) return all;
    }
    throw archive_fault(server_, "the series has more than " + std::to_string(kMostInstances) + " instances",
                        "fetch another");
  }

  void receive(const std::string& path, SeriesReceiver& receiver) const {
    const HttpClient http(server_);
    ReceivedFile file;
    const MultipartReader::Part part{
        [&] { file.open(receiver.next_file()); }, [&](const char* data, std::size_t bytes) { file.write(data, bytes); },
        [&](bool whole) {
          file.close();
          if (!whole) throw archive_fault(server_, "a part of its answer is cut short", "fetch it again");
          receiver.take(file.path());
        }};
    std::optional<MultipartReader> reader;
    const HttpSink sink = [&](const std::string& type, const char* data, std::size_t bytes) {
      if (!reader) {
        const auto boundary = boundary_of(type);
        if (!boundary)
          throw archive_fault(
              server_,
              "it sent " + (type.empty() ? "something" : one_line(type, 60)) + " rather than the parts of a series",
              "check that its URL is that of DICOMweb");
        reader.emplace(*boundary, part);
      }
      receiver.count(bytes);
      if (!reader->feed(data, bytes)) throw archive_fault(server_, "its answer is damaged", "fetch it again");
    };
    const HttpAnswer answer = http.get(path, kParts, sink, [&] { receiver.wait(); });
    http.require_ok(answer, "such series");
    if (!reader) throw archive_fault(server_, "its answer is empty", "ask who runs the archive");
    if (!reader->complete()) throw archive_fault(server_, "its answer is cut short", "fetch it again");
  }

  void store(const HttpClient& http, const fs::path& file, Outgoing& outgoing) const {
    PartSource source(file);
    HttpBody body;
    body.content_type = std::string("multipart/related; type=\"application/dicom\"; boundary=") + kBoundary;
    body.length = source.length();
    body.read = [&](char* to, std::size_t most) {
      const std::size_t count = source.read(to, most);
      outgoing.count(count);
      return count;
    };
    const HttpAnswer answer = http.post("/studies", kJson, body, [&] { outgoing.count(0); });
    if (answer.status != 409) http.require_ok(answer, "DICOMweb at its URL");
    const StoreAnswer stored = store_answer_of_json(answer.body);
    if (answer.status == 409 || stored.refused > 0)
      throw archive_fault(
          server_, "it refuses " + quoted(file.filename()) + (stored.reason.empty() ? "" : " (" + stored.reason + ")"),
          "ask who runs the archive");
    outgoing.stored(stored.warning);
  }

  const ArchiveServer server_;
};

}  // namespace

std::unique_ptr<Archive> open_dicom_web(const ArchiveServer& server) { return std::make_unique<WebArchive>(server); }

}  // namespace simplexseg
