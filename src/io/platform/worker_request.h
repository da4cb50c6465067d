// SPDX-License-Identifier: Apache-2.0
// Typed requests to the worker process: both processes use one RequestType, so that arguments and results agree.
#pragma once
#include <filesystem>
#include <string>
#include <type_traits>

#include "io/platform/packing.h"
#include "io/platform/worker_process.h"

namespace simplexseg {

/// Name of a request with the types of its result and of its arguments after the file. The result is void when the
/// response is a stream of bytes.
template <class Result, class... Arguments>
struct RequestType {
  const char* name;
};

/// Returns name and arguments of a request. The path becomes absolute, because a process keeps its working folder.
template <class Result, class... Arguments>
std::string packed_request(const RequestType<Result, Arguments...>& type, const std::filesystem::path& file,
                           const std::type_identity_t<Arguments>&... arguments) {
  Packer to;
  pack(to, std::string(type.name));
  pack(to, std::filesystem::absolute(file));
  (pack(to, arguments), ...);
  return to.bytes();
}

/// Waits for the result of a request. Throws like WorkerRequest.
template <class Result, class... Arguments>
Result result_of(WorkerRequest& request, const RequestType<Result, Arguments...>&) {
  const std::string response = request.finish();
  try {
    return unpacked<Result>(response);
  } catch (const BadPacking& fault) {
    throw WorkerFailure(fault.what());
  }
}

/// Performs a request and returns its result. Throws like WorkerRequest.
template <class Result, class... Arguments>
Result request_result(const RequestType<Result, Arguments...>& type, const std::filesystem::path& file,
                      const WorkerLimits& limits, const std::type_identity_t<Arguments>&... arguments) {
  WorkerRequest request(packed_request(type, file, arguments...), file, limits);
  return result_of(request, type);
}

}  // namespace simplexseg
