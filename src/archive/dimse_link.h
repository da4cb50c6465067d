// SPDX-License-Identifier: Apache-2.0
// DIMSE association (PS3.8) through DCMTK, which only the source file includes.
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

/// Attribute of a query with the value to match; an empty value requests the attribute.
struct DimseKey {
  DicomTag tag;
  std::string value;
};
/// Values of the requested attributes in a response, in the order of the keys; UTF-8, multiple values separated by
/// backslashes.
using DimseEntry = std::vector<std::string>;

/// Presentation context, negotiated at the start of an association.
struct DimseContext {
  std::string abstract_syntax;
  std::vector<std::string> transfer_syntaxes;
  bool we_receive = false;  ///< the archive sends objects to us (C-STORE sub-operations)
};

/// One association. All members except the destructor throw ArchiveFault (see Archive) when it ends early.
class DimseLink {
 public:
  /// `on_bytes`: called with the bytes transferred, at least once a second; its exceptions are passed on.
  DimseLink(const ArchiveServer& server, const std::vector<DimseContext>& contexts,
            std::function<void(std::uint64_t)> on_bytes);
  ~DimseLink();
  DimseLink(const DimseLink&) = delete;
  DimseLink& operator=(const DimseLink&) = delete;

  void echo();
  /// C-FIND in the study root model, cancelled after `max_entries` entries. `level`: STUDY, SERIES or IMAGE.
  std::vector<DimseEntry> find(const std::string& level, const std::vector<DimseKey>& keys, std::size_t max_entries);
  /// C-GET of a series.
  void get(const std::string& study, const std::string& series, SeriesReceiver& receiver);
  /// C-STORE. Returns a warning of the archive, or an empty text.
  std::string store(const Outgoing::Instance& instance);

 private:
  class Requester;
  std::unique_ptr<Requester> requester_;
};

}  // namespace simplexseg
