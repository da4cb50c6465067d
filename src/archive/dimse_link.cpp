// SPDX-License-Identifier: Apache-2.0
#include "archive/dimse_link.h"

#include <dcmtk/config/osconfig.h>
#include <dcmtk/dcmdata/dctk.h>
#include <dcmtk/dcmnet/dcmlayer.h>
#include <dcmtk/dcmnet/dcmtrans.h>
#include <dcmtk/dcmnet/diutil.h>
#include <dcmtk/dcmnet/scu.h>
#include <dcmtk/oflog/oflog.h>
#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <exception>
#include <mutex>
#include <optional>

#include "archive/faults.h"
#include "io/dicom/dicom_texts.h"
#include "io/platform/files.h"
#include "remote/callback_guard.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr int kPollMs = 200;

/// State of a connection. The guard stores exceptions, since DCMTK would leak memory if they passed through it.
struct Watch : CallbackGuard {
  std::function<void(std::uint64_t)> on_bytes;
  int timeout_s = 30;
  bool timed_out = false, ended = false;

  bool report(std::uint64_t bytes) {
    return guarded([&] { on_bytes(bytes); });
  }
  /// Waits up to `limit_s` seconds for a socket, in short intervals so that `on_bytes` can cancel. Returns false after
  /// a time-out or a cancellation.
  bool wait(int socket, short event, int limit_s) {
    pollfd one{socket, event, 0};
    for (int left_ms = limit_s * 1000;; left_ms -= kPollMs) {
      if (!report(0)) return false;
      const int ready = ::poll(&one, 1, std::min(std::max(left_ms, 0), kPollMs));
      if (ready > 0) return true;
      if (left_ms <= kPollMs) return false;
    }
  }
};

class WatchedConnection : public DcmTCPConnection {
 public:
  WatchedConnection(DcmNativeSocketType socket, Watch& watch) : DcmTCPConnection(socket), watch_(watch) {}

  ssize_t read(void* to, size_t capacity) override {
    if (!watch_.wait(getSocket(), POLLIN, watch_.timeout_s)) {
      watch_.timed_out = !watch_.thrown;
      return -1;
    }
    const ssize_t count = ::recv(getSocket(), to, capacity, 0);
    if (count <= 0) watch_.ended = true;
    return count > 0 && !watch_.report(static_cast<std::uint64_t>(count)) ? -1 : count;
  }
  ssize_t write(void* from, size_t count) override {
    size_t done = 0;
    while (done < count) {
      if (!watch_.wait(getSocket(), POLLOUT, watch_.timeout_s)) {
        watch_.timed_out = !watch_.thrown;
        return -1;
      }
      const ssize_t sent =
          ::send(getSocket(), static_cast<char*>(from) + done, count - done, MSG_DONTWAIT | MSG_NOSIGNAL);
      if (sent < 0 && (errno == EAGAIN || errno == EINTR)) continue;
      if (sent <= 0) watch_.ended = true;
      if (sent <= 0 || !watch_.report(static_cast<std::uint64_t>(sent))) return -1;
      done += static_cast<size_t>(sent);
    }
    return static_cast<ssize_t>(done);
  }
  OFBool networkDataAvailable(int timeout) override {
    const bool available = watch_.wait(getSocket(), POLLIN, timeout);
    if (!available && !watch_.thrown && timeout > 0) watch_.timed_out = true;
    return available;
  }

 private:
  Watch& watch_;
};

class WatchedLayer : public DcmTransportLayer {
 public:
  explicit WatchedLayer(Watch& watch) : watch_(watch) {}
  DcmTransportConnection* createConnection(DcmNativeSocketType socket, OFBool) override {
    return new WatchedConnection(socket, watch_);
  }

 private:
  Watch& watch_;
};

/// Turns off the log of DCMTK, which may contain patient names.
void silence() {
  static std::once_flag once;
  std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
}

/// Converts to the text type of DCMTK, which is std::string or a class of DCMTK, depending on how DCMTK was built.
OFString of_string(const std::string& text) { return {text.data(), text.size()}; }
std::string std_string(const OFString& text) { return {text.data(), text.size()}; }

DcmTagKey key_of(DicomTag tag) { return {tag.group, tag.element}; }

bool is_ascii(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x80; });
}

}  // namespace

class DimseLink::Requester : public DcmSCU {
 public:
  Requester(const ArchiveServer& server, std::function<void(std::uint64_t)> on_bytes)
      : server_(server), layer_(watch_) {
    watch_.on_bytes = std::move(on_bytes);
    watch_.timeout_s = server.timeout_s;
  }
  ~Requester() override {
    if (isConnected()) abortAssociation();
    freeNetwork();  // before the layer is destroyed
  }

  void connect(const std::vector<DimseContext>& contexts) {
    const auto seconds = static_cast<Uint32>(server_.timeout_s);
    setAETitle(of_string(server_.calling_title));
    setPeerAETitle(of_string(server_.called_title));
    setPeerHostName(of_string(server_.host));
    setPeerPort(static_cast<Uint16>(server_.port));
    setConnectionTimeout(server_.timeout_s);
    setACSETimeout(seconds);
    setDIMSETimeout(seconds);
    setDIMSEBlockingMode(DIMSE_NONBLOCKING);
    setStorageMode(DCMSCU_STORAGE_BIT_PRESERVING);
    setDatasetConversionMode(OFTrue);
    for (const DimseContext& context : contexts) {
      OFList<OFString> syntaxes;
      for (const std::string& one : context.transfer_syntaxes) syntaxes.push_back(of_string(one));
      addPresentationContext(of_string(context.abstract_syntax), syntaxes,
                             context.we_receive ? ASC_SC_ROLE_SCP : ASC_SC_ROLE_DEFAULT);
    }
    require(initNetwork());
    require(useSecureConnection(&layer_));  // sets the transport layer, which does not encrypt here
    const OFCondition result = negotiateAssociation();
    if (result == DUL_ASSOCIATIONREJECTED && !watch_.thrown)
      throw archive_fault(
          server_, "it rejected the AE title " + server_.called_title + ", or our AE title " + server_.calling_title,
          "check both titles, and that our title is registered in the archive");
    if (result == NET_EC_NoAcceptablePresentationContexts && !watch_.thrown)
      throw archive_fault(server_, "it does not support the requested service", kAskAdministrator);
    require(result);
  }

  /// Rethrows the exception of a callback, or throws the ArchiveFault for a failed condition.
  void require(const OFCondition& result) const {
    if (watch_.thrown) std::rethrow_exception(watch_.thrown);
    if (result.good()) return;
    if (watch_.timed_out || result == DIMSE_NODATAAVAILABLE) throw timed_out(server_);
    if (watch_.ended || result == DUL_PEERREQUESTEDRELEASE || result == DUL_PEERABORTEDASSOCIATION ||
        result == DUL_NETWORKCLOSED)
      throw connection_lost(server_, "unexpectedly");
    const std::string text = one_line(result.text(), 200);
    if (text.find("nknown Host") != std::string::npos) throw unknown_host(server_);
    if (!isConnected() && (text.find("TCP") != std::string::npos || text.find("refused") != std::string::npos))
      throw text.find("imeout") != std::string::npos ? timed_out(server_) : connection_refused(server_);
    throw archive_fault(server_, "it does not respond like an archive: " + text, "check its host and port");
  }

  /// Whether the association can still be released regularly (A-RELEASE).
  bool can_release() const { return isConnected() && !watch_.thrown && !watch_.timed_out && !watch_.ended; }

  T_ASC_PresentationContextID context_for(const char* abstract_syntax) {
    const T_ASC_PresentationContextID id = findPresentationContextID(abstract_syntax, "");
    if (id == 0)
      throw archive_fault(
          server_, "it does not support " + std::string(dcmFindNameOfUID(abstract_syntax, "the requested service")),
          kAskAdministrator);
    return id;
  }

  OFCondition handleFINDResponse(const T_ASC_PresentationContextID id, QRResponse* response, OFBool& wait) override {
    const OFCondition result = DcmSCU::handleFINDResponse(id, response, wait);
    status = response->m_status;
    DcmDataset* const data = response->m_dataset;
    if (!data || !DICOM_PENDING_STATUS(status)) return result;
    OFString character_set;
    data->findAndGetOFStringArray(DCM_SpecificCharacterSet, character_set);
    DimseEntry& entry = entries.emplace_back();
    for (const DicomTag tag : requested_tags) {
      OFString value;
      data->findAndGetOFStringArray(key_of(tag), value);
      std::string text = one_line(utf8_of(std_string(value), std_string(character_set)), 200);
      entry.push_back(std::move(text));
    }
    if (entries.size() >= max_entries) {
      sendCANCELRequest(id);
      wait = OFFalse;
    }
    return result;
  }

  OFCondition handleCGETResponse(const T_ASC_PresentationContextID id, RetrieveResponse* response,
                                 OFBool& continue_session) override {
    status = response->m_status;
    return DcmSCU::handleCGETResponse(id, response, continue_session);
  }

  OFCondition handleSTORERequestFile(T_ASC_PresentationContextID* id, const OFString&,
                                     T_DIMSE_C_StoreRQ* request) override {
    fs::path file;
    OFCondition result = EC_IllegalCall;
    if (!watch_.guarded([&] { file = receiver->next_file(); })) return result;
    result = DcmSCU::handleSTORERequestFile(id, file.c_str(), request);
    if (result.bad() && !watch_.ended && !watch_.timed_out) {
      watch_.guarded([&] {
        throw ArchiveFault("cannot store received files in " + quoted(file.parent_path()), "a file cannot be written",
                           "free space on the disk");
      });
    }
    if (result.good() && !watch_.guarded([&] { receiver->add(file); })) result = EC_IllegalCall;
    return result;
  }

  const ArchiveServer& server_;
  unsigned status = 0;
  std::vector<DicomTag> requested_tags;
  std::size_t max_entries = 0;
  std::vector<DimseEntry> entries;
  SeriesReceiver* receiver = nullptr;

 private:
  Watch watch_;
  WatchedLayer layer_;
};

DimseLink::DimseLink(const ArchiveServer& server, const std::vector<DimseContext>& contexts,
                     std::function<void(std::uint64_t)> on_bytes) {
  silence();
  requester_ = std::make_unique<Requester>(server, std::move(on_bytes));
  requester_->connect(contexts);
}

DimseLink::~DimseLink() {
  if (requester_->can_release()) requester_->releaseAssociation();
}

void DimseLink::echo() {
  requester_->require(requester_->sendECHORequest(requester_->context_for(UID_VerificationSOPClass)));
}

std::vector<DimseEntry> DimseLink::find(const std::string& level, const std::vector<DimseKey>& keys,
                                        std::size_t max_entries) {
  DcmDataset query;
  query.putAndInsertString(DCM_QueryRetrieveLevel, level.c_str());
  requester_->requested_tags.clear();
  for (const DimseKey& key : keys) {
    if (!is_ascii(key.value)) query.putAndInsertString(DCM_SpecificCharacterSet, "ISO_IR 192");
    query.putAndInsertString(key_of(key.tag), key.value.c_str());
    requester_->requested_tags.push_back(key.tag);
  }
  requester_->max_entries = max_entries;
  requester_->entries.clear();
  const auto id = requester_->context_for(UID_FINDStudyRootQueryRetrieveInformationModel);
  requester_->require(requester_->sendFINDRequest(id, &query, nullptr));
  const unsigned status = requester_->status;
  if (status != STATUS_Success && !DICOM_PENDING_STATUS(status))
    throw archive_fault(requester_->server_, "the search failed (" + status_text(status) + ")", "try again later");
  return std::move(requester_->entries);
}

void DimseLink::get(const std::string& study, const std::string& series, SeriesReceiver& receiver) {
  DcmDataset query;
  query.putAndInsertString(DCM_QueryRetrieveLevel, "SERIES");
  query.putAndInsertString(DCM_StudyInstanceUID, study.c_str());
  query.putAndInsertString(DCM_SeriesInstanceUID, series.c_str());
  requester_->receiver = &receiver;
  const auto id = requester_->context_for(UID_GETStudyRootQueryRetrieveInformationModel);
  requester_->require(requester_->sendCGETRequest(id, &query, nullptr));
}

std::string DimseLink::store(const Outgoing::Instance& instance) {
  Uint16 status = 0;
  const DicomIdentity& identity = instance.identity;
  const auto id =
      requester_->findAnyPresentationContextID(of_string(identity.sop_class), of_string(identity.transfer_syntax));
  const std::string name = quoted(instance.file.filename());
  if (id == 0)
    throw archive_fault(
        requester_->server_,
        "it does not accept " + std::string(dcmFindNameOfUID(identity.sop_class.c_str(), "the type")) + " of " + name,
        kAskAdministrator);
  requester_->require(requester_->sendSTORERequest(id, instance.file.c_str(), nullptr, status));
  if (status == STATUS_Success) return {};
  if (!DICOM_WARNING_STATUS(status))
    throw archive_fault(requester_->server_, "it rejected " + name + " (" + status_text(status) + ")",
                        kAskAdministrator);
  return "the archive stored " + name + " with a warning (" + status_text(status) + ")";
}

}  // namespace simplexseg
