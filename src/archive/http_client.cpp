// SPDX-License-Identifier: Apache-2.0
#include "archive/http_client.h"

#include <curl/curl.h>

#include <cctype>
#include <exception>
#include <memory>
#include <mutex>

#include "archive/below_c.h"
#include "archive/faults.h"
#include "io/files.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMostAnswer = 32'000'000;  ///< of an answer that is kept in memory
constexpr std::size_t kMostComplaint = 4096;     ///< of one that tells a failure
constexpr long kLeastBytesPerSecond = 10;        ///< below it nothing comes
constexpr long kMostTimeouts = 20;               ///< that a whole small answer may take

struct HandleCloser {
  void operator()(CURL* handle) const { curl_easy_cleanup(handle); }
};
struct ListCloser {
  void operator()(curl_slist* list) const { curl_slist_free_all(list); }
};

CURL* new_handle() {
  static std::once_flag once;
  std::call_once(once, [] { curl_global_init(CURL_GLOBAL_DEFAULT); });
  return curl_easy_init();
}

}  // namespace

/// What the callbacks, which stand below C code, know. They must not throw: it is thrown again behind it.
struct HttpClient::Transfer : BelowC {
  const HttpSink* sink = nullptr;
  const HttpBody* body = nullptr;
  const std::function<void()>* waiting = nullptr;
  CURL* handle = nullptr;
  HttpAnswer answer;
  bool too_large = false;

  void take_status() {
    long status = 0;
    curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
    const char* type = nullptr;
    curl_easy_getinfo(handle, CURLINFO_CONTENT_TYPE, &type);
    answer.status = static_cast<int>(status);
    answer.content_type = type ? type : "";
  }

  static std::size_t on_data(char* data, std::size_t, std::size_t bytes, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    const bool taken = transfer.guarded([&] {
      HttpAnswer& answer = transfer.answer;
      if (answer.status == 0) transfer.take_status();
      const bool ok = answer.status == 200;
      if (ok && transfer.sink) return (*transfer.sink)(answer.content_type, data, bytes);
      const std::size_t most = answer.status < 300 ? kMostAnswer : kMostComplaint;
      transfer.too_large = answer.status < 300 && answer.body.size() + bytes > most;
      if (answer.body.size() < most) answer.body.append(data, std::min(bytes, most - answer.body.size()));
    });
    return taken && !transfer.too_large ? bytes : 0;
  }
  static std::size_t on_room(char* to, std::size_t, std::size_t most, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    std::size_t count = 0;
    return transfer.guarded([&] { count = transfer.body->read(to, most); }) ? count : CURL_READFUNC_ABORT;
  }
  static int on_time(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    auto& transfer = *static_cast<Transfer*>(self);
    return transfer.guarded([&] { (*transfer.waiting)(); }) ? 0 : 1;
  }
};

HttpClient::HttpClient(const ArchiveServer& server) : server_(server), credentials_(read_credentials(server)) {}

HttpAnswer HttpClient::get(const std::string& path, const std::string& accept,
                           const std::function<void()>& waiting) const {
  Transfer transfer;
  transfer.waiting = &waiting;
  return perform(path, accept, transfer);
}

HttpAnswer HttpClient::get(const std::string& path, const std::string& accept, const HttpSink& sink,
                           const std::function<void()>& waiting) const {
  Transfer transfer;
  transfer.sink = &sink, transfer.waiting = &waiting;
  return perform(path, accept, transfer);
}

HttpAnswer HttpClient::post(const std::string& path, const std::string& accept, const HttpBody& body,
                            const std::function<void()>& waiting) const {
  Transfer transfer;
  transfer.body = &body, transfer.waiting = &waiting;
  return perform(path, accept, transfer);
}

HttpAnswer HttpClient::perform(const std::string& path, const std::string& accept, Transfer& transfer) const {
  const std::unique_ptr<CURL, HandleCloser> owner(new_handle());
  CURL* const handle = owner.get();
  if (!handle) throw archive_fault(server_, "libcurl cannot be started", "free some memory");
  transfer.handle = handle;
  const auto set = [handle](CURLoption option, auto value) { curl_easy_setopt(handle, option, value); };
  char words[CURL_ERROR_SIZE] = "";
  const std::string url = server_.url + path;
  curl_slist* lines = curl_slist_append(nullptr, ("Accept: " + accept).c_str());
  if (transfer.body) {
    lines = curl_slist_append(lines, ("Content-Type: " + transfer.body->content_type).c_str());
    lines = curl_slist_append(lines, "Expect:");
    set(CURLOPT_POST, 1L);
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(transfer.body->length));
    set(CURLOPT_READFUNCTION, &Transfer::on_room);
    set(CURLOPT_READDATA, static_cast<void*>(&transfer));
  }
  const std::unique_ptr<curl_slist, ListCloser> header(lines);
  set(CURLOPT_ERRORBUFFER, words);
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  set(CURLOPT_NOSIGNAL, 1L);
  set(CURLOPT_USERAGENT, "SimplexSeg");
  set(CURLOPT_HTTPHEADER, header.get());
  set(CURLOPT_SSL_VERIFYPEER, 1L);
  set(CURLOPT_SSL_VERIFYHOST, 2L);
  const std::string certificates = server_.ca_file.string();
  if (!certificates.empty()) {
    set(CURLOPT_CAINFO, certificates.c_str());
    set(CURLOPT_CAPATH, static_cast<const char*>(nullptr));
  }
  if (!credentials_.basic.empty()) {
    set(CURLOPT_HTTPAUTH, CURLAUTH_BASIC);
    set(CURLOPT_USERPWD, credentials_.basic.c_str());
  } else if (!credentials_.bearer.empty()) {
    set(CURLOPT_HTTPAUTH, CURLAUTH_BEARER);
    set(CURLOPT_XOAUTH2_BEARER, credentials_.bearer.c_str());
  }
  set(CURLOPT_CONNECTTIMEOUT, static_cast<long>(server_.timeout_s));
  set(CURLOPT_LOW_SPEED_LIMIT, kLeastBytesPerSecond);
  set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(server_.timeout_s));
  if (!transfer.sink && !transfer.body) {
    set(CURLOPT_TIMEOUT, kMostTimeouts * server_.timeout_s);
    set(CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(kMostAnswer));
  }
  set(CURLOPT_WRITEFUNCTION, &Transfer::on_data);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&transfer));
  set(CURLOPT_XFERINFOFUNCTION, &Transfer::on_time);
  set(CURLOPT_XFERINFODATA, static_cast<void*>(&transfer));
  set(CURLOPT_NOPROGRESS, 0L);
  const CURLcode code = curl_easy_perform(handle);
  if (transfer.thrown) std::rethrow_exception(transfer.thrown);
  if (code != CURLE_OK) throw fault_of(code, words, transfer);
  transfer.take_status();
  return std::move(transfer.answer);
}

ArchiveFault HttpClient::fault_of(int curl_code, const char* words, const Transfer& transfer) const {
  const std::string said = one_line(*words ? words : curl_easy_strerror(static_cast<CURLcode>(curl_code)), 200);
  switch (curl_code) {
    case CURLE_COULDNT_CONNECT:
      return refused_connection(server_);
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
      return unknown_host(server_);
    case CURLE_OPERATION_TIMEDOUT:
      return timed_out(server_);
    case CURLE_PEER_FAILED_VERIFICATION:
      return archive_fault(server_, "its certificate is not trusted: " + said,
                           "name the file of the authority that made it, if you trust that");
    case CURLE_SSL_CACERT_BADFILE:
      return archive_fault(server_, "the certificates in " + quoted(server_.ca_file) + " cannot be read",
                           "name a file of certificates (PEM)");
    case CURLE_SSL_CONNECT_ERROR:
      return archive_fault(server_, "no secure connection: " + said, "check that its port speaks https");
    case CURLE_FILESIZE_EXCEEDED:
      return too_large(server_, "its answer", kMostAnswer);
    case CURLE_WRITE_ERROR:
      if (transfer.too_large) return too_large(server_, "its answer", kMostAnswer);
      break;
    case CURLE_GOT_NOTHING:
      return ended_early(server_, "before an answer came");
    case CURLE_SEND_ERROR:
      return ended_early(server_, "while something was sent");
    case CURLE_RECV_ERROR:
    case CURLE_PARTIAL_FILE:
      return ended_early(server_, "in the middle of its answer");
    default:
      break;
  }
  return archive_fault(server_, "its answer is not that of an archive: " + said, "check its URL");
}

void HttpClient::require_ok(const HttpAnswer& answer, const std::string& what) const {
  if (answer.status >= 200 && answer.status < 300) return;
  const std::string number = " (" + std::to_string(answer.status) + ")";
  const bool knows_us = !credentials_.basic.empty() || !credentials_.bearer.empty();
  switch (answer.status) {
    case 401:
      throw archive_fault(server_, (knows_us ? "it refuses the credentials" : "it wants credentials") + number,
                          "name a variable or a file with them that is right");
    case 403:
      throw archive_fault(server_, "it forbids this to its user" + number, "ask who runs the archive");
    case 404:
      throw archive_fault(server_, "it has no " + what + number, "check its URL, and search again");
    case 413:
      throw archive_fault(server_, "what was sent is too large for it" + number, "ask who runs the archive");
    default:
      break;
  }
  if (answer.status >= 300 && answer.status < 400)
    throw archive_fault(server_, "it sends elsewhere" + number, "give the URL that it has now");
  throw archive_fault(server_, "it failed" + number, "try again later, or ask who runs the archive");
}

std::string url_escaped(const std::string& text) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string escaped;
  for (const unsigned char c : text) {
    if ((std::isalnum(c) && c < 0x80) || c == '-' || c == '.' || c == '_' || c == '~' || c == '*')
      escaped += static_cast<char>(c);
    else
      escaped.append("%").append(1, kDigits[c >> 4]).append(1, kDigits[c & 15]);
  }
  return escaped;
}

}  // namespace simplexseg
