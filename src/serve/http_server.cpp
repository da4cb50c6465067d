// SPDX-License-Identifier: Apache-2.0
#include "serve/http_server.h"

#include "core/error.h"

#ifdef SIMPLEXSEG_HAS_HTTPLIB
// These include Eigen, which must come before httplib: its system headers define the macro _res.
#include "core/number_text.h"
#include "serve/client_connection.h"
#include "serve/service.h"

#include <httplib.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <thread>
#include <utility>

namespace simplexseg {
namespace {

constexpr std::uint64_t kLargeBody = 1 << 20;  // bytes; larger ones are received one at a time
constexpr std::size_t kThreads = 16;
constexpr const char* kJson = "application/json";

/// Connection as a stream of the library.
class LimitedStream : public httplib::Stream {
 public:
  LimitedStream(int socket, const std::atomic<bool>& stopped) : connection_(socket, stopped) {}

  bool is_readable() const override { return true; }  // read() waits
  bool is_writable() const override { return true; }
  ssize_t read(char* to, std::size_t size) override { return connection_.read(to, size); }
  ssize_t write(const char* from, std::size_t size) override { return connection_.write(from, size); }
  void get_remote_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  void get_local_ip_and_port(std::string& /*ip*/, int& /*port*/) const override {}
  socket_t socket() const override { return connection_.socket(); }
  void finish() { connection_.finish(); }

 private:
  ClientConnection connection_;
};

/// Server whose connections have limits that the library lacks: total time and size of the headers.
class LimitedServer : public httplib::Server {
 public:
  explicit LimitedServer(const std::atomic<bool>& stopped) : stopped_(stopped) {}

 private:
  bool process_and_close_socket(socket_t socket) override {
    LimitedStream stream(socket, stopped_);
    bool closed = false;
    const bool done = process_request(stream, true, closed, [](httplib::Request&) {});
    stream.finish();
    ::close(socket);
    return done;
  }

  const std::atomic<bool>& stopped_;
};

ServiceRequest request_of(const httplib::Request& from) {
  ServiceRequest request{from.method, from.path, from.get_header_value("Authorization"),
                         from.get_header_value("X-Lease-Token"), from.get_header_value("X-Meta")};
  const std::optional<std::int64_t> length = parse_integer(from.get_header_value("Content-Length"));
  if (length && *length >= 0 && from.get_header_value_count("Content-Length") == 1)
    request.body_bytes = static_cast<std::uint64_t>(*length);
  return request;
}

void send(const ServiceResponse& response, httplib::Response& to) {
  to.status = response.status;
  if (!response.meta.empty()) to.set_header("X-Meta", response.meta);
  if (response.retry_s > 0) to.set_header("Retry-After", std::to_string(response.retry_s));
  to.set_content(response.body, response.meta.empty() ? kJson : "application/octet-stream");
}

ServiceResponse transport_refusal(int status, const std::string& detail) {
  return {status, "{\"detail\":\"" + detail + "\"}"};
}

}  // namespace

struct HttpServer::Impl {
  explicit Impl(SegmentationService& used) : service(used), server(stopped) {
    server.new_task_queue = [] { return new httplib::ThreadPool(kThreads); };  // the library owns and deletes it
    // Not the default of the library, with which a second server could listen on the same port.
    server.set_socket_options([](socket_t socket) {
      const int yes = 1;
      ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    });
    server.set_pre_routing_handler([this](const httplib::Request& from, httplib::Response& to) {
      std::optional<ServiceResponse> response = refusal(from);
      if (!response && from.method == "GET") response = service.handle(request_of(from));
      if (!response) return httplib::Server::HandlerResponse::Unhandled;
      send(*response, to);
      return httplib::Server::HandlerResponse::Handled;
    });
    server.Post(".*", [this](const httplib::Request& from, httplib::Response& to, const httplib::ContentReader& read) {
      receive(from, to, read);
    });
    server.set_exception_handler([](const httplib::Request&, httplib::Response& to, const std::exception_ptr&) {
      send(transport_refusal(500, "internal error"), to);
    });
    server.set_error_handler([](const httplib::Request&, httplib::Response& to) {
      if (to.body.empty()) send(transport_refusal(to.status, "the request could not be read"), to);
    });
  }

  static std::optional<ServiceResponse> refusal_of_transport(const httplib::Request& from) {
    if (from.has_header("Origin")) return transport_refusal(403, "this server does not serve browsers");
    if (from.has_header("Content-Encoding") || from.is_multipart_form_data())
      return transport_refusal(415, "the body must be neither compressed nor in parts");
    if (from.has_header("Transfer-Encoding")) return transport_refusal(411, "the length of the body is missing");
    if (from.has_header("Range")) return transport_refusal(400, "ranges of a response are not supported");
    return std::nullopt;
  }

  std::optional<ServiceResponse> refusal(const httplib::Request& from) {
    if (std::optional<ServiceResponse> refused = refusal_of_transport(from)) return refused;
    return service.refusal(request_of(from));
  }

  /// Permission to receive a large body; null while another request has it.
  std::unique_ptr<std::atomic<bool>, void (*)(std::atomic<bool>*)> permission() {
    return {receiving.exchange(true) ? nullptr : &receiving, [](std::atomic<bool>* given) { *given = false; }};
  }

  void receive(const httplib::Request& from, httplib::Response& to, const httplib::ContentReader& read) {
    ServiceRequest request = request_of(from);
    const bool is_large = request.body_bytes.value_or(0) > kLargeBody;
    if (!is_large) return process(request, to, read);
    if (const auto permitted = permission()) return process(request, to, read);
    ServiceResponse busy = transport_refusal(503, "another request is being received; try again later");
    busy.retry_s = 1;
    send(busy, to);
  }

  void process(ServiceRequest& request, httplib::Response& to, const httplib::ContentReader& read) {
    const bool complete = read([&](const char* bytes, std::size_t size) {
      request.body.append(bytes, size);
      return true;
    });
    const bool whole = complete && request.body.size() == request.body_bytes.value_or(0);
    send(whole ? service.handle(request) : transport_refusal(400, "the body is incomplete"), to);
  }

  SegmentationService& service;
  std::atomic<bool> stopped = false, receiving = false, ended = false;
  LimitedServer server;
  int port = 0;
  std::thread thread;
};

HttpServer::HttpServer(SegmentationService& service, const std::string& address, int port)
    : impl_(std::make_unique<Impl>(service)) {
  is_loopback(address);  // throws for an address that is none
  const bool bound = port == 0 ? (impl_->port = impl_->server.bind_to_any_port(address)) > 0
                               : impl_->server.bind_to_port(address, port);
  if (port != 0) impl_->port = port;
  if (!bound)
    throw Error("port " + std::to_string(port) + " of " + address,
                "it is in use, not permitted, or the address is not one of this computer",
                "use another --port or --listen");
  impl_->thread = std::thread([this] {
    impl_->server.listen_after_bind();
    impl_->ended = true;
  });
}

HttpServer::~HttpServer() {
  stop();
  if (impl_->thread.joinable()) impl_->thread.join();
}

int HttpServer::port() const { return impl_->port; }

void HttpServer::stop() {
  impl_->stopped = true;
  impl_->service.stop();
  // Before the thread listens, stop() of the library has no effect.
  while (!impl_->server.is_running() && !impl_->ended) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  impl_->server.stop();
}

}  // namespace simplexseg

#else

namespace simplexseg {

struct HttpServer::Impl {};

HttpServer::HttpServer(SegmentationService&, const std::string&, int) {
  throw Error("serve", "this program was built without libcpp-httplib",
              "install libcpp-httplib-dev and build it again");
}
HttpServer::~HttpServer() = default;
int HttpServer::port() const { return 0; }
void HttpServer::stop() {}

}  // namespace simplexseg

#endif
