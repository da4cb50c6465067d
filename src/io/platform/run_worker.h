// SPDX-License-Identifier: Apache-2.0
// Main function of a worker process, and its table of requests.
#pragma once
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <tuple>

#include "io/platform/packing.h"
#include "io/platform/worker_channel.h"
#include "io/platform/worker_program.h"
#include "io/platform/worker_request.h"

namespace simplexseg {

using RequestHandler = std::function<void(Unpacker& from, ResponseWriter& response)>;
using RequestTable = std::map<std::string, RequestHandler>;

template <class T>
T next_value(Unpacker& from) {
  T value{};
  unpack(from, value);
  return value;
}

/// Adds a request whose response is the result of `f`.
template <class Result, class... Arguments>
void add_request(RequestTable& table, const RequestType<Result, Arguments...>& type,
                 Result (*f)(const std::filesystem::path&, const Arguments&...)) {
  table[type.name] = [f](Unpacker& from, ResponseWriter& response) {
    const std::tuple<std::filesystem::path, Arguments...> arguments{next_value<std::filesystem::path>(from),
                                                                    next_value<Arguments>(from)...};
    response.text(FrameKind::Result, packed(std::apply(f, arguments)));
  };
}

/// Adds a request whose response is the data that `f` sends.
template <class... Arguments>
void add_stream(RequestTable& table, const RequestType<void, Arguments...>& type,
                void (*f)(ResponseWriter&, const std::filesystem::path&, const Arguments&...)) {
  table[type.name] = [f](Unpacker& from, ResponseWriter& response) {
    const std::tuple<std::filesystem::path, Arguments...> arguments{next_value<std::filesystem::path>(from),
                                                                    next_value<Arguments>(from)...};
    std::apply([&](const auto&... each) { f(response, each...); }, arguments);
    response.text(FrameKind::Result, "");
  };
}

/// Serves the requests of another process on the socket kWorkerChannel until that process closes it, or no request
/// arrives for kWorkerIdleSeconds; then deletes the temporary folder and exits. Each request has limits of memory and
/// processor time (RequestHead). Arguments of the program: version and temporary folder. Returns the exit status when
/// the program was started by hand.
int run_worker(int argc, char** argv, const WorkerProgram& program, const RequestTable& table);

/// Receives the next `bytes` bytes of the attachments of the current request. For use in the worker process.
void receive_attachment(void* to, std::size_t bytes);

}  // namespace simplexseg
