// SPDX-License-Identifier: Apache-2.0
// A connection of DICOM's own (PS3.8) by DCMTK, which is known in the source alone.
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
#include "io/dicom_values.h"

namespace simplexseg {

/// An attribute of a query, and the value to match; empty: it is asked for.
struct DimseKey {
  DicomTag tag;
  std::string value;
};
/// What an answer has of the attributes that were asked for, in their order; UTF-8, several values with a backslash
/// between them.
using DimseEntry = std::vector<std::string>;

/// What an association is for; it is negotiated at its beginning.
struct DimseContext {
  std::string abstract_syntax;
  std::vector<std::string> transfer_syntaxes;
  bool we_receive = false;  ///< the archive stores at ours
};

/// One association. All but the destructor throw Error for whatever ends it, as Archive says.
class DimseLink {
 public:
  /// `came`: bytes that went over the network, at least once a second, 0 while none do; what it throws comes through.
  DimseLink(const ArchiveServer& server, const std::vector<DimseContext>& contexts,
            std::function<void(std::uint64_t)> came);
  ~DimseLink();
  DimseLink(const DimseLink&) = delete;
  DimseLink& operator=(const DimseLink&) = delete;

  void echo();
  /// C-FIND below the study root; of `most` entries at most, then it is called off. `level`: STUDY, SERIES, IMAGE.
  std::vector<DimseEntry> find(const std::string& level, const std::vector<DimseKey>& keys, std::size_t most);
  /// C-GET of a series.
  void get(const std::string& study, const std::string& series, SeriesReceiver& receiver);
  /// C-STORE. Gives what the archive says of it, or nothing.
  std::string store(const Outgoing::Instance& instance);

 private:
  class Requester;
  std::unique_ptr<Requester> requester_;
};

}  // namespace simplexseg
