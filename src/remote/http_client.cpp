// SPDX-License-Identifier: Apache-2.0
#include "remote/http_client.h"

#include <curl/curl.h>

#include <exception>
#include <memory>
#include <mutex>

#include "core/number_text.h"
#include "io/platform/files.h"
#include "remote/callback_guard.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxErrorBody = 4096;  ///< largest stored part of an error response, bytes
constexpr const char* kNarrowRequest = "narrow the search";
constexpr long kMinBytesPerSecond = 10;  ///< a transfer that is slower for the time-out is cancelled
constexpr long kMaxTimeouts = 20;        ///< limit for a small request, in time-outs of the server

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

/// State of a request for the callbacks of libcurl, which must not throw.
struct HttpClient::Transfer : CallbackGuard {
  const HttpSink* sink = nullptr;
  const HttpBody* body = nullptr;
  const std::function<void()>* waiting = nullptr;
  std::uint64_t max_bytes = HttpRequest().max_bytes;
  CURL* handle = nullptr;
  HttpResponse response;
  bool too_large = false;

  void read_status() {
    long status = 0;
    curl_easy_getinfo(handle, CURLINFO_RESPONSE_CODE, &status);
    const char* type = nullptr;
    curl_easy_getinfo(handle, CURLINFO_CONTENT_TYPE, &type);
    response.status = static_cast<int>(status);
    response.content_type = type ? type : "";
  }

  static std::size_t on_data(char* data, std::size_t, std::size_t bytes, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    const bool accepted = transfer.guarded([&] {
      HttpResponse& response = transfer.response;
      if (response.status == 0) transfer.read_status();
      const bool ok = response.status == 200;
      if (ok && transfer.sink) return (*transfer.sink)(response.content_type, data, bytes);
      const std::size_t limit = response.status < 300 ? transfer.max_bytes : kMaxErrorBody;
      transfer.too_large = response.status < 300 && response.body.size() + bytes > limit;
      if (response.body.size() < limit) response.body.append(data, std::min(bytes, limit - response.body.size()));
    });
    return accepted && !transfer.too_large ? bytes : 0;
  }
  static std::size_t on_header(char* data, std::size_t, std::size_t bytes, void* self) {
    constexpr std::string_view kMeta = "x-meta:";
    const std::string_view line(data, bytes);
    if (bytes < kMeta.size() || lower_ascii(line.substr(0, kMeta.size())) != kMeta) return bytes;
    std::string& meta = static_cast<Transfer*>(self)->response.meta;
    meta = line.substr(kMeta.size());
    while (!meta.empty() && is_space(meta.back())) meta.pop_back();
    meta.erase(0, std::min(meta.find_first_not_of(' '), meta.size()));
    return bytes;
  }
  static std::size_t on_read(char* to, std::size_t, std::size_t capacity, void* self) {
    auto& transfer = *static_cast<Transfer*>(self);
    std::size_t count = 0;
    return transfer.guarded([&] { count = transfer.body->read(to, capacity); }) ? count : CURL_READFUNC_ABORT;
  }
  static int on_time(void* self, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    auto& transfer = *static_cast<Transfer*>(self);
    return transfer.guarded([&] { (*transfer.waiting)(); }) ? 0 : 1;
  }
};

HttpClient::HttpClient(const WebServer& server) : server_(server), credentials_(read_credentials(server)) {}

HttpResponse HttpClient::get(const std::string& path, const std::string& accept,
                             const std::function<void()>& waiting) const {
  Transfer transfer;
  transfer.waiting = &waiting;
  return perform({"GET", path, accept, {}, "", ""}, transfer);
}

HttpResponse HttpClient::get(const std::string& path, const std::string& accept, const HttpSink& sink,
                             const std::function<void()>& waiting) const {
  Transfer transfer;
  transfer.sink = &sink, transfer.waiting = &waiting;
  return perform({"GET", path, accept, {}, "", ""}, transfer);
}

HttpResponse HttpClient::post(const std::string& path, const std::string& accept, const HttpBody& body,
                              const std::function<void()>& waiting) const {
  Transfer transfer;
  transfer.body = &body, transfer.waiting = &waiting;
  return perform({"POST", path, accept, {}, "", ""}, transfer);
}

HttpResponse HttpClient::send(const HttpRequest& request, const std::function<void()>& waiting) const {
  std::size_t sent = 0;
  const HttpBody body{request.content_type, request.content.size(), [&](char* to, std::size_t capacity) {
                        const std::size_t count = std::min(capacity, request.content.size() - sent);
                        request.content.copy(to, count, sent);
                        sent += count;
                        return count;
                      }};
  Transfer transfer;
  transfer.waiting = &waiting, transfer.max_bytes = request.max_bytes;
  if (request.method == "POST" || request.method == "PUT") transfer.body = &body;
  return perform(request, transfer);
}

HttpResponse HttpClient::perform(const HttpRequest& request, Transfer& transfer) const {
  const std::unique_ptr<CURL, HandleCloser> owner(new_handle());
  CURL* const handle = owner.get();
  if (!handle) throw remote_fault(server_, "libcurl cannot be started", "close other programs to free memory");
  transfer.handle = handle;
  const auto set = [handle](CURLoption option, auto value) { curl_easy_setopt(handle, option, value); };
  char error_text[CURL_ERROR_SIZE] = "";
  const std::string url = server_.url + request.path;
  curl_slist* lines = curl_slist_append(nullptr, ("Accept: " + request.accept).c_str());
  for (const auto& [name, value] : request.headers) {
    std::string line = name;
    line += ": ";
    line += value;
    lines = curl_slist_append(lines, line.c_str());
  }
  if (transfer.body) {
    lines = curl_slist_append(lines, ("Content-Type: " + transfer.body->content_type).c_str());
    lines = curl_slist_append(lines, "Expect:");
    set(CURLOPT_POST, 1L);
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(transfer.body->length));
    set(CURLOPT_READFUNCTION, &Transfer::on_read);
    set(CURLOPT_READDATA, static_cast<void*>(&transfer));
  }
  const std::unique_ptr<curl_slist, ListCloser> header(lines);
  if (request.method != "GET") set(CURLOPT_CUSTOMREQUEST, request.method.c_str());
  set(CURLOPT_ERRORBUFFER, error_text);
  set(CURLOPT_URL, url.c_str());
  set(CURLOPT_PROTOCOLS_STR, "http,https");
  set(CURLOPT_FOLLOWLOCATION, 0L);
  if (is_own_url(server_.url)) set(CURLOPT_NOPROXY, "*");  // a proxy would send the image to another machine
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
  set(CURLOPT_LOW_SPEED_LIMIT, kMinBytesPerSecond);
  set(CURLOPT_LOW_SPEED_TIME, static_cast<long>(server_.timeout_s));
  if (!transfer.sink && !transfer.body) {
    set(CURLOPT_TIMEOUT, kMaxTimeouts * server_.timeout_s);
    set(CURLOPT_MAXFILESIZE_LARGE, static_cast<curl_off_t>(transfer.max_bytes));
  }
  set(CURLOPT_HEADERFUNCTION, &Transfer::on_header);
  set(CURLOPT_HEADERDATA, static_cast<void*>(&transfer));
  set(CURLOPT_WRITEFUNCTION, &Transfer::on_data);
  set(CURLOPT_WRITEDATA, static_cast<void*>(&transfer));
  set(CURLOPT_XFERINFOFUNCTION, &Transfer::on_time);
  set(CURLOPT_XFERINFODATA, static_cast<void*>(&transfer));
  set(CURLOPT_NOPROGRESS, 0L);
  const CURLcode code = curl_easy_perform(handle);
  if (transfer.thrown) std::rethrow_exception(transfer.thrown);
  if (code != CURLE_OK) throw fault_of(code, error_text, transfer);
  transfer.read_status();
  return std::move(transfer.response);
}

RemoteFault HttpClient::fault_of(int curl_code, const char* error_text, const Transfer& transfer) const {
  const std::string text =
      one_line(*error_text ? error_text : curl_easy_strerror(static_cast<CURLcode>(curl_code)), 200);
  switch (curl_code) {
    case CURLE_COULDNT_CONNECT:
      return connection_refused(server_);
    case CURLE_COULDNT_RESOLVE_HOST:
    case CURLE_COULDNT_RESOLVE_PROXY:
      return unknown_host(server_);
    case CURLE_OPERATION_TIMEDOUT:
      return timed_out(server_);
    case CURLE_PEER_FAILED_VERIFICATION:
      return remote_fault(server_, "its certificate is not trusted: " + text,
                          "if you trust its issuer, name the file with the issuer's certificate");
    case CURLE_SSL_CACERT_BADFILE:
      return remote_fault(server_, "the certificates in " + quoted(server_.ca_file) + " cannot be read",
                          "use a PEM file");
    case CURLE_SSL_CONNECT_ERROR:
      return remote_fault(server_, "no secure connection: " + text, "check that its port accepts https");
    case CURLE_FILESIZE_EXCEEDED:
      return too_large(server_, "its response", transfer.max_bytes, kNarrowRequest);
    case CURLE_WRITE_ERROR:
      if (transfer.too_large) return too_large(server_, "its response", transfer.max_bytes, kNarrowRequest);
      break;
    case CURLE_GOT_NOTHING:
      return connection_lost(server_, "before a response arrived");
    case CURLE_SEND_ERROR:
      return connection_lost(server_, "during sending");
    case CURLE_RECV_ERROR:
    case CURLE_PARTIAL_FILE:
      return connection_lost(server_, "in the middle of its response");
    default:
      break;
  }
  return remote_fault(server_, "it does not respond like " + server_.kind + ": " + text, "check its URL");
}

void HttpClient::require_ok(const HttpResponse& response, const std::string& what) const {
  if (response.status >= 200 && response.status < 300) return;
  const std::string number = " (" + std::to_string(response.status) + ")";
  const bool has_credentials = !credentials_.basic.empty() || !credentials_.bearer.empty();
  switch (response.status) {
    case 401:
      throw remote_fault(server_,
                         (has_credentials ? "it rejected the credentials" : "it requires credentials") + number,
                         "use a variable or a file with valid credentials");
    case 403:
      throw remote_fault(server_, "it denies access" + number, server_.administrator);
    case 404:
      throw remote_fault(server_, "it has no " + what + number, "check its URL, and search again");
    case 413:
      throw remote_fault(server_, "the file is too large for it" + number, server_.administrator);
    default:
      break;
  }
  if (response.status >= 300 && response.status < 400)
    throw remote_fault(server_, "it redirects to another URL" + number, "use its current URL");
  throw remote_fault(server_, "it failed" + number, "try again later");
}

std::string url_escaped(const std::string& text) {
  constexpr char kDigits[] = "0123456789ABCDEF";
  std::string escaped;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (is_ascii_letter(c) || is_ascii_digit(c) || std::string_view("-._~*").find(c) != std::string_view::npos)
      escaped += c;
    else
      escaped.append("%").append(1, kDigits[byte >> 4]).append(1, kDigits[byte & 15]);
  }
  return escaped;
}

}  // namespace simplexseg
