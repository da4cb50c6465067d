// SPDX-License-Identifier: Apache-2.0
// DIMSE association (PS3.7, PS3.8) through DCMTK. Only the source file includes headers of DCMTK.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "archive/archive.h"
#include "archive/outgoing.h"
#include "archive/receiver.h"
#include "io/dicom/dicom_values.h"

namespace simplexseg {

/// Attribute of a query with the value to match; an empty value matches all and requests the attribute.
struct DimseKey {
  DicomTag tag;
  std::string value;
};
/// Values of the requested attributes in a response, in the order of the keys, as UTF-8. Multiple values of one
/// attribute are separated by backslashes.
using DimseEntry = std::vector<std::string>;

/// Presentation context, proposed at the start of an association.
struct DimseContext {
  std::string abstract_syntax;
  std::vector<std::string> transfer_syntaxes;
  bool we_receive = false;  ///< the archive sends objects to this program (C-STORE sub-operations)
};

/// Association with an archive. All members except the destructor throw ArchiveFault (see Archive) for a failure.
class DimseLink {
 public:
  /// Opens the association. `on_bytes`: called at least once a second with the number of bytes transferred since the
  /// last call; its exceptions are passed on. `server` must outlive this object.
  DimseLink(const ArchiveServer& server, const std::vector<DimseContext>& contexts,
            std::function<void(std::uint64_t)> on_bytes);
  ~DimseLink();
  DimseLink(const DimseLink&) = delete;
  DimseLink& operator=(const DimseLink&) = delete;

  void echo();
  /// Searches by C-FIND in the study root model; cancels the search after `max_entries` entries. `level`: STUDY, SERIES
  /// or IMAGE.
  std::vector<DimseEntry> find(const std::string& level, const std::vector<DimseKey>& keys, std::size_t max_entries);
  /// Fetches a series by C-GET and adds its instances to `receiver`. `study`, `series`: UIDs.
  void get(const std::string& study, const std::string& series, SeriesReceiver& receiver);
  /// Sends an instance by C-STORE. Returns a warning of the archive, or an empty text.
  std::string store(const Outgoing::Instance& instance);

 private:
  class Requester;
  std::unique_ptr<Requester> requester_;
};

}  // namespace simplexseg
