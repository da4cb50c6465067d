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
#include <cstdio>
#include <exception>
#include <mutex>
#include <optional>

#include "archive/below_c.h"
#include "archive/faults.h"
#include "io/dicom_texts.h"
#include "io/files.h"

namespace simplexseg {
namespace fs = std::filesystem;

namespace {

constexpr int kSlice_ms = 200;

/// What a connection tells of itself. DCMTK's code lies between those who throw and those who catch, and would leak.
struct Watch : BelowC {
  std::function<void(std::uint64_t)> came;
  int timeout_s = 30;
  bool timed_out = false, ended = false;

  bool tell(std::uint64_t bytes) {
    return guarded([&] { came(bytes); });
  }
  /// Waits for a socket, a slice at a time, so that it can be called off.
  bool wait(int socket, short event, int limit_s) {
    pollfd one{socket, event, 0};
    for (int left_ms = limit_s * 1000;; left_ms -= kSlice_ms) {
      if (!tell(0)) return false;
      const int ready = ::poll(&one, 1, std::min(std::max(left_ms, 0), kSlice_ms));
      if (ready > 0) return true;
      if (left_ms <= kSlice_ms) return false;
    }
  }
};

class WatchedConnection : public DcmTCPConnection {
 public:
  WatchedConnection(DcmNativeSocketType socket, Watch& watch) : DcmTCPConnection(socket), watch_(watch) {}

  ssize_t read(void* to, size_t most) override {
    if (!watch_.wait(getSocket(), POLLIN, watch_.timeout_s)) {
      watch_.timed_out = !watch_.thrown;
      return -1;
    }
    const ssize_t count = ::recv(getSocket(), to, most, 0);
    if (count <= 0) watch_.ended = true;
    return count > 0 && !watch_.tell(static_cast<std::uint64_t>(count)) ? -1 : count;
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
      if (sent <= 0 || !watch_.tell(static_cast<std::uint64_t>(sent))) return -1;
      done += static_cast<size_t>(sent);
    }
    return static_cast<ssize_t>(done);
  }
  OFBool networkDataAvailable(int timeout) override {
    const bool there = watch_.wait(getSocket(), POLLIN, timeout);
    if (!there && !watch_.thrown && timeout > 0) watch_.timed_out = true;
    return there;
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

/// DCMTK logs whole data sets, names of patients among them.
void silence() {
  static std::once_flag once;
  std::call_once(once, [] { OFLog::configure(OFLogger::OFF_LOG_LEVEL); });
}

std::string hexadecimal(unsigned status) {
  char text[16];
  std::snprintf(text, sizeof text, "%04X", status);
  return text;
}

/// DCMTK's text is std::string or a type of its own, as it was built.
OFString of_string(const std::string& text) { return {text.data(), text.size()}; }
std::string std_string(const OFString& text) { return {text.data(), text.size()}; }

DcmTagKey key_of(DicomTag tag) { return {tag.group, tag.element}; }

bool is_ascii(const std::string& text) {
  return std::all_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x80; });
}

}  // namespace

class DimseLink::Requester : public DcmSCU {
 public:
  Requester(const ArchiveServer& server, std::function<void(std::uint64_t)> came) : server_(server), layer_(watch_) {
    watch_.came = std::move(came);
    watch_.timeout_s = server.timeout_s;
  }
  ~Requester() override {
    if (isConnected()) abortAssociation();
    freeNetwork();  // while the layer is there
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
    require(useSecureConnection(&layer_));  // of a layer's own; this one encrypts nothing
    const OFCondition result = negotiateAssociation();
    if (result == DUL_ASSOCIATIONREJECTED && !watch_.thrown)
      throw archive_fault(server_,
                          "it rejects the title " + server_.called_title + " or ours, " + server_.calling_title,
                          "check both, and that it knows ours");
    if (result == NET_EC_NoAcceptablePresentationContexts && !watch_.thrown)
      throw archive_fault(server_, "it does not offer what is asked for", "ask who runs the archive");
    require(result);
  }

  /// Throws what the watch caught, or the fault that the condition tells.
  void require(const OFCondition& result) const {
    if (watch_.thrown) std::rethrow_exception(watch_.thrown);
    if (result.good()) return;
    if (watch_.timed_out || result == DIMSE_NODATAAVAILABLE) throw timed_out(server_);
    if (watch_.ended || result == DUL_PEERREQUESTEDRELEASE || result == DUL_PEERABORTEDASSOCIATION ||
        result == DUL_NETWORKCLOSED)
      throw ended_early(server_, "in the middle");
    const std::string said = one_line(result.text(), 200);
    if (said.find("nknown Host") != std::string::npos) throw unknown_host(server_);
    if (!isConnected() && (said.find("TCP") != std::string::npos || said.find("refused") != std::string::npos))
      throw said.find("imeout") != std::string::npos ? timed_out(server_) : refused_connection(server_);
    throw archive_fault(server_, "its answer is not that of an archive: " + said, "check its host and port");
  }

  /// Whether the archive can still be told that we go.
  bool is_sound() const { return isConnected() && !watch_.thrown && !watch_.timed_out && !watch_.ended; }

  T_ASC_PresentationContextID context_for(const char* abstract_syntax) {
    const T_ASC_PresentationContextID id = findPresentationContextID(abstract_syntax, "");
    if (id == 0)
      throw archive_fault(server_,
                          "it does not offer " + std::string(dcmFindNameOfUID(abstract_syntax, "what is asked for")),
                          "ask who runs the archive");
    return id;
  }

  OFCondition handleFINDResponse(const T_ASC_PresentationContextID id, QRResponse* response, OFBool& wait) override {
    const OFCondition result = DcmSCU::handleFINDResponse(id, response, wait);
    status = response->m_status;
    DcmDataset* const data = response->m_dataset;
    if (!data || !DICOM_PENDING_STATUS(status)) return result;
    OFString set;
    data->findAndGetOFStringArray(DCM_SpecificCharacterSet, set);
    DimseEntry& entry = entries.emplace_back();
    for (const DicomTag tag : wanted) {
      OFString value;
      data->findAndGetOFStringArray(key_of(tag), value);
      std::string text = one_line(utf8_of(std_string(value), std_string(set)), 200);
      entry.push_back(std::move(text));
    }
    if (entries.size() >= most) {
      sendCANCELRequest(id);
      wait = OFFalse;
    }
    return result;
  }

  OFCondition handleCGETResponse(const T_ASC_PresentationContextID id, RetrieveResponse* response,
                                 OFBool& go_on) override {
    status = response->m_status;
    return DcmSCU::handleCGETResponse(id, response, go_on);
  }

  OFCondition handleSTORERequestFile(T_ASC_PresentationContextID* id, const OFString&,
                                     T_DIMSE_C_StoreRQ* request) override {
    fs::path file;
    OFCondition result = EC_IllegalCall;
    if (!watch_.guarded([&] { file = receiver->next_file(); })) return result;
    result = DcmSCU::handleSTORERequestFile(id, file.c_str(), request);
    if (result.bad() && !watch_.ended && !watch_.timed_out) {
      watch_.guarded([&] {
        throw ArchiveFault("cannot keep what comes in " + quoted(file.parent_path()), "the file cannot be written",
                           "check the space left on the disk and the permissions");
      });
    }
    if (result.good() && !watch_.guarded([&] { receiver->take(file); })) result = EC_IllegalCall;
    return result;
  }

  const ArchiveServer& server_;
  unsigned status = 0;
  std::vector<DicomTag> wanted;
  std::size_t most = 0;
  std::vector<DimseEntry> entries;
  SeriesReceiver* receiver = nullptr;

 private:
  Watch watch_;
  WatchedLayer layer_;
};

DimseLink::DimseLink(const ArchiveServer& server, const std::vector<DimseContext>& contexts,
                     std::function<void(std::uint64_t)> came) {
  silence();
  requester_ = std::make_unique<Requester>(server, std::move(came));
  requester_->connect(contexts);
}

DimseLink::~DimseLink() {
  if (requester_->is_sound()) requester_->releaseAssociation();
}

void DimseLink::echo() {
  requester_->require(requester_->sendECHORequest(requester_->context_for(UID_VerificationSOPClass)));
}

std::vector<DimseEntry> DimseLink::find(const std::string& level, const std::vector<DimseKey>& keys, std::size_t most) {
  DcmDataset query;
  query.putAndInsertString(DCM_QueryRetrieveLevel, level.c_str());
  requester_->wanted.clear();
  for (const DimseKey& key : keys) {
    if (!is_ascii(key.value)) query.putAndInsertString(DCM_SpecificCharacterSet, "ISO_IR 192");
    query.putAndInsertString(key_of(key.tag), key.value.c_str());
    requester_->wanted.push_back(key.tag);
  }
  requester_->most = most;
  requester_->entries.clear();
  const auto id = requester_->context_for(UID_FINDStudyRootQueryRetrieveInformationModel);
  requester_->require(requester_->sendFINDRequest(id, &query, nullptr));
  const unsigned status = requester_->status;
  if (status != STATUS_Success && !DICOM_PENDING_STATUS(status))
    throw archive_fault(requester_->server_, "it failed to search (" + hexadecimal(status) + ")",
                        "try again later, or ask who runs the archive");
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
        "it takes no " + std::string(dcmFindNameOfUID(identity.sop_class.c_str(), "object")) + " as in " + name,
        "ask who runs the archive");
  requester_->require(requester_->sendSTORERequest(id, instance.file.c_str(), nullptr, status));
  if (status == STATUS_Success) return {};
  if (!DICOM_WARNING_STATUS(status))
    throw archive_fault(requester_->server_, "it refuses " + name + " (" + hexadecimal(status) + ")",
                        "ask who runs the archive");
  return "the archive took " + name + " with a warning (" + hexadecimal(status) + ")";
}

}  // namespace simplexseg
