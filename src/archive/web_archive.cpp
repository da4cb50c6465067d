// SPDX-License-Identifier: Apache-2.0
// Archive over DICOMweb: QIDO-RS, WADO-RS, STOW-RS (PS3.18, 10).
#include <cstring>
#include <fstream>
#include <optional>

#include "archive/faults.h"
#include "archive/implementations.h"
#include "archive/match.h"
#include "archive/outgoing.h"
#include "archive/receiver.h"
#include "archive/web_json.h"
#include "io/platform/files.h"
#include "remote/http_client.h"
#include "remote/multipart.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr const char* kJson = "application/dicom+json";
constexpr const char* kParts = "multipart/related; type=\"application/dicom\"; transfer-syntax=*";
constexpr std::size_t kPage = 1000;  ///< number of instances that a request asks for
constexpr const char* kBoundary = "simplexseg-5c7e2f90d14b4a63";

std::string query_of(const ArchiveQuery& query) {
  std::string text = "/studies?limit=" + std::to_string(query.max_studies + 1);
  for (const auto& [key, value] :
       {std::pair("PatientName", part_pattern(query.patient_name)), std::pair("PatientID", query.patient_id),
        std::pair("StudyDate", dicom_date_range(query.date)), std::pair("ModalitiesInStudy", query.modality),
        std::pair("StudyDescription", part_pattern(query.description)), std::pair("StudyInstanceUID", query.study)})
    if (!value.empty()) text.append("&").append(key).append("=").append(url_escaped(value));
  for (const char* tag : {"00081030", "00080061", "00201206", "00201208"}) text.append("&includefield=").append(tag);
  return text;
}

/// Body of a multipart request whose only part is a file.
class PartSource {
 public:
  explicit PartSource(const fs::path& file)
      : before_(std::string("--") + kBoundary + "\r\nContent-Type: application/dicom\r\n\r\n"),
        after_(std::string("\r\n--") + kBoundary + "--\r\n"),
        stream_(file, std::ios::binary),
        length_(fs::file_size(file)) {}
  std::uint64_t length() const { return before_.size() + length_ + after_.size(); }

  /// Copies the next block of the body and returns its length; 0, an early end, if the file has become shorter.
  std::size_t read(char* to, std::size_t capacity) {
    if (std::size_t count = copy_from(before_, to, capacity)) return count;
    if (stream_) {
      stream_.read(to, static_cast<std::streamsize>(std::min<std::uint64_t>(capacity, length_ - sent_)));
      const auto count = static_cast<std::size_t>(stream_.gcount());
      sent_ += count;
      if (count > 0) return count;
    }
    return sent_ == length_ ? copy_from(after_, to, capacity) : 0;
  }

 private:
  static std::size_t copy_from(std::string& from, char* to, std::size_t capacity) {
    const std::size_t count = std::min(capacity, from.size());
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

  void check(const ArchiveProgress& progress) override {
    get_json("/studies?limit=1", "DICOMweb at its URL", progress);
  }

  FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress) override {
    require_query(query);
    FoundStudies found;
    found.studies = studies_of_json(server_, get_json(query_of(query), "DICOMweb at its URL", progress));
    sort_studies(found, query.max_studies);
    return found;
  }

  std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress) override {
    require_uid(study, "study");
    const std::string path = "/studies/" + study + "/series?includefield=0008103E&includefield=00201209";
    std::vector<ArchiveSeries> series = series_of_json(server_, get_json(path, "such study", progress), study);
    if (series.empty()) throw not_found(server_, "such study");
    sort_series(series);
    return series;
  }

  fs::path fetch(const std::string& study, const std::string& series, const ArchiveCache& cache,
                 const ArchiveProgress& progress) override {
    require_uid(study, "study"), require_uid(series, "series");
    const std::string path = "/studies/" + study + "/series/" + series;
    const std::set<std::string> expected = instances_of(path, progress);
    if (expected.empty()) throw not_found(server_, "such series");
    if (const auto cached = cache.find(server_, series, expected)) return *cached;
    SeriesReceiver receiver(server_, cache, series, expected, progress);
    receive(path, receiver);
    return receiver.finish();
  }

  ArchiveSent send(const std::vector<fs::path>& files, const ArchiveProgress& progress) override {
    Outgoing outgoing(server_, files, progress);
    const HttpClient http(web_server_of(server_));
    for (const Outgoing::Instance& instance : outgoing.instances())
      outgoing.guard([&] { store(http, instance.file, outgoing); });
    return outgoing.sent();
  }

 private:
  /// Requests a path and returns the body of the small response; empty for status 204. `what`: see require_ok().
  std::string get_json(const std::string& path, const std::string& what, const ArchiveProgress& progress) const {
    const HttpClient http(web_server_of(server_));
    HttpResponse response = http.get(path, kJson, [&] { report_progress(progress, {}); });
    http.require_ok(response, what);
    return std::move(response.body);
  }

  /// UIDs of all instances of a series. An archive may return fewer instances than requested, so requests are repeated
  /// until no UID is new. `path`: path of the series.
  std::set<std::string> instances_of(const std::string& path, const ArchiveProgress& progress) const {
    std::set<std::string> all;
    for (std::size_t before = 0; all.size() < kMaxInstances; before = all.size()) {
      const std::string page = path + "/instances?limit=" + std::to_string(kPage) + "&offset=" + std::to_string(before);
      all.merge(instances_of_json(server_, get_json(page, "such series", progress)));
      if (all.size() == before) return all;
    }
    throw archive_fault(server_, "the series has more than " + std::to_string(kMaxInstances) + " instances",
                        "choose another series");
  }

  void receive(const std::string& path, SeriesReceiver& receiver) const {
    const HttpClient http(web_server_of(server_));
    ReceivedFile file;
    const MultipartReader::Part part{
        [&] { file.open(receiver.next_file()); }, [&](const char* data, std::size_t bytes) { file.write(data, bytes); },
        [&](bool complete) {
          file.close();
          if (!complete) throw archive_fault(server_, "a part of its response is incomplete", "fetch it again");
          receiver.add(file.path());
        }};
    std::optional<MultipartReader> reader;
    const HttpSink sink = [&](const std::string& type, const char* data, std::size_t bytes) {
      if (!reader) {
        const auto boundary = boundary_of(type);
        if (!boundary)
          throw archive_fault(
              server_, "it sent " + (type.empty() ? "an unknown type" : one_line(type, 60)) + " instead of a series",
              "check that its URL is the one for DICOMweb");
        reader.emplace(*boundary, part);
      }
      receiver.count(bytes);
      if (!reader->feed(data, bytes)) throw archive_fault(server_, "its response is damaged", "fetch it again");
    };
    const HttpResponse response = http.get(path, kParts, sink, [&] { receiver.wait(); });
    http.require_ok(response, "such series");
    if (!reader) throw archive_fault(server_, "its response is empty", kAskAdministrator);
    if (!reader->complete()) throw archive_fault(server_, "its response is incomplete", "fetch it again");
  }

  void store(const HttpClient& http, const fs::path& file, Outgoing& outgoing) const {
    PartSource source(file);
    HttpBody body;
    body.content_type = std::string("multipart/related; type=\"application/dicom\"; boundary=") + kBoundary;
    body.length = source.length();
    body.read = [&](char* to, std::size_t capacity) {
      const std::size_t count = source.read(to, capacity);
      outgoing.count(count);
      return count;
    };
    const HttpResponse response = http.post("/studies", kJson, body, [&] { outgoing.count(0); });
    if (response.status != 409) http.require_ok(response, "DICOMweb at its URL");
    const StoreResponse stored = store_response_of_json(response.body);
    if (response.status == 409 || stored.rejected > 0)
      throw archive_fault(
          server_, "it rejected " + quoted(file.filename()) + (stored.reason.empty() ? "" : " (" + stored.reason + ")"),
          kAskAdministrator);
    outgoing.stored(stored.warning);
  }

  const ArchiveServer server_;
};

}  // namespace

std::unique_ptr<Archive> open_dicom_web(const ArchiveServer& server) { return std::make_unique<WebArchive>(server); }

}  // namespace simplexseg
