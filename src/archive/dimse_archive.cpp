// SPDX-License-Identifier: Apache-2.0
// Archive over DIMSE: C-ECHO, C-FIND, C-GET, C-STORE (PS3.4, PS3.7).
#include <algorithm>
#include <set>

#include "archive/dimse_link.h"
#include "archive/faults.h"
#include "archive/implementations.h"
#include "archive/match.h"
#include "io/dicom/dicom_texts.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr const char* kVerification = "1.2.840.10008.1.1";
constexpr const char* kFind = "1.2.840.10008.5.1.4.1.2.2.1";  // study root, like kGet
constexpr const char* kGet = "1.2.840.10008.5.1.4.1.2.2.3";
constexpr const char *kImplicit = "1.2.840.10008.1.2", *kExplicit = "1.2.840.10008.1.2.1";
/// Compressed transfer syntaxes: JPEG baseline, extended and lossless, JPEG-LS, JPEG 2000, RLE.
constexpr const char* kCompressed[] = {"1.2.840.10008.1.2.4.50", "1.2.840.10008.1.2.4.51", "1.2.840.10008.1.2.4.57",
                                       "1.2.840.10008.1.2.4.70", "1.2.840.10008.1.2.4.80", "1.2.840.10008.1.2.4.81",
                                       "1.2.840.10008.1.2.4.90", "1.2.840.10008.1.2.4.91", "1.2.840.10008.1.2.5"};
constexpr std::size_t kMaxContexts = 120;            ///< presentation contexts proposed; DICOM allows 128
constexpr std::uint64_t kMaxResponse = 100'000'000;  ///< largest size of all responses to a query, bytes

constexpr DicomTag kStudy{0x0020, 0x000d}, kSeries{0x0020, 0x000e}, kInstance{0x0008, 0x0018}, kClass{0x0008, 0x0016};

std::vector<std::string> values_of(const std::string& text) {
  std::vector<std::string> values;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\\', at), text.size());
    if (end > at && values.size() < 20) values.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return values;
}

class DimseArchive : public Archive {
 public:
  explicit DimseArchive(ArchiveServer server) : server_(std::move(server)) {}

  void check(const ArchiveProgress& progress) override {
    DimseLink link(server_, {{kVerification, {kImplicit, kExplicit}}}, bounded(progress));
    link.echo();
  }

  FoundStudies find_studies(const ArchiveQuery& query, const ArchiveProgress& progress) override {
    require_query(query);
    DimseLink link(server_, {{kFind, {kExplicit, kImplicit}}}, bounded(progress));
    const std::vector<DimseKey> keys = {{kStudy, query.study},
                                        {{0x0010, 0x0010}, part_pattern(query.patient_name)},
                                        {{0x0010, 0x0020}, query.patient_id},
                                        {{0x0008, 0x0020}, dicom_date_range(query.date)},
                                        {{0x0008, 0x1030}, part_pattern(query.description)},
                                        {{0x0008, 0x0061}, query.modality},
                                        {{0x0020, 0x1206}, ""},
                                        {{0x0020, 0x1208}, ""}};
    FoundStudies found;
    for (const DimseEntry& entry : link.find("STUDY", keys, static_cast<std::size_t>(query.max_studies) + 1)) {
      if (!is_dicom_uid(entry[0])) continue;
      found.studies.push_back({.uid = entry[0],
                               .patient_name = display_name(entry[1]),
                               .patient_id = entry[2],
                               .date = display_date(entry[3]),
                               .description = entry[4],
                               .modalities = values_of(entry[5]),
                               .series = count_in(entry[6], -1),
                               .instances = count_in(entry[7], -1)});
    }
    sort_studies(found, query.max_studies);
    return found;
  }

  std::vector<ArchiveSeries> find_series(const std::string& study, const ArchiveProgress& progress) override {
    require_uid(study, "study");
    DimseLink link(server_, {{kFind, {kExplicit, kImplicit}}}, bounded(progress));
    const std::vector<DimseKey> keys = {{kStudy, study},        {kSeries, ""},          {{0x0020, 0x0011}, ""},
                                        {{0x0008, 0x0060}, ""}, {{0x0008, 0x103e}, ""}, {{0x0020, 0x1209}, ""}};
    std::vector<ArchiveSeries> all;
    for (const DimseEntry& entry : link.find("SERIES", keys, kMaxInstances)) {
      if (!is_dicom_uid(entry[1])) continue;
      all.push_back({.study = study,
                     .uid = entry[1],
                     .number = count_in(entry[2], 0),
                     .modality = entry[3],
                     .description = entry[4],
                     .instances = count_in(entry[5], -1)});
    }
    if (all.empty()) throw not_found(server_, "such study");
    sort_series(all);
    return all;
  }

  fs::path fetch(const std::string& study, const std::string& series, const ArchiveCache& cache,
                 const ArchiveProgress& progress) override {
    require_uid(study, "study"), require_uid(series, "series");
    std::set<std::string> expected, classes;
    {
      DimseLink link(server_, {{kFind, {kExplicit, kImplicit}}}, bounded(progress));
      const std::vector<DimseKey> keys = {{kStudy, study}, {kSeries, series}, {kInstance, ""}, {kClass, ""}};
      for (const DimseEntry& entry : link.find("IMAGE", keys, kMaxInstances)) {
        if (is_dicom_uid(entry[2])) expected.insert(entry[2]);
        if (is_dicom_uid(entry[3])) classes.insert(entry[3]);
      }
    }
    if (expected.empty()) throw not_found(server_, "such series");
    if (const auto cached = cache.find(server_, series, expected)) return *cached;
    SeriesReceiver receiver(server_, cache, series, expected, progress);
    DimseLink link(server_, contexts_to_get(classes), [&](std::uint64_t bytes) { receiver.count(bytes); });
    link.get(study, series, receiver);
    return receiver.finish();
  }

  ArchiveSent send(const std::vector<fs::path>& files, const ArchiveProgress& progress) override {
    Outgoing outgoing(server_, files, progress);
    std::set<std::pair<std::string, std::string>> kinds;
    for (const Outgoing::Instance& one : outgoing.instances())
      kinds.insert({one.identity.sop_class, one.identity.transfer_syntax});
    std::vector<DimseContext> contexts;
    for (const auto& [sop_class, syntax] : kinds) {
      contexts.push_back({sop_class, {syntax}});
      if (syntax == kExplicit) contexts.push_back({sop_class, {kImplicit}});
    }
    if (contexts.size() > kMaxContexts)
      throw archive_fault(server_, "the files are of too many different types for one connection",
                          "send fewer files at once");
    outgoing.guard([&] {
      DimseLink link(server_, contexts, [&](std::uint64_t bytes) { outgoing.count(bytes); });
      for (const Outgoing::Instance& one : outgoing.instances()) outgoing.stored(link.store(one));
    });
    return outgoing.sent();
  }

 private:
  /// Callback that reports progress and throws ArchiveFault when the responses to a query are larger than kMaxResponse.
  std::function<void(std::uint64_t)> bounded(const ArchiveProgress& progress) const {
    return [this, &progress, sum = std::uint64_t{0}](std::uint64_t bytes) mutable {
      if ((sum += bytes) > kMaxResponse) throw too_large(server_, "its response", kMaxResponse, kNarrowSearch);
      report_progress(progress, {});
    };
  }

  /// Presentation contexts for C-GET. The uncompressed transfer syntaxes of a SOP class share a context. Each
  /// compressed one has a separate context, up to kMaxContexts in total, so that the archive need not decompress
  /// instances.
  std::vector<DimseContext> contexts_to_get(const std::set<std::string>& classes) const {
    std::vector<DimseContext> contexts = {{kGet, {kExplicit, kImplicit}}};
    for (const std::string& one : classes) contexts.push_back({one, {kExplicit, kImplicit}, true});
    for (const std::string& one : classes)
      for (const char* syntax : kCompressed)
        if (contexts.size() < kMaxContexts) contexts.push_back({one, {syntax}, true});
    if (classes.empty() || classes.size() > kMaxContexts)
      throw archive_fault(server_, "it reports no SOP classes of the instances, or too many", kAskAdministrator);
    return contexts;
  }

  const ArchiveServer server_;
};

}  // namespace

std::unique_ptr<Archive> open_dimse(const ArchiveServer& server) { return std::make_unique<DimseArchive>(server); }

}  // namespace simplexseg
