// SPDX-License-Identifier: Apache-2.0
// Fuzz targets: messages of servers (tests/remote/fuzz_seeds_test.cpp). A message that has two parts begins with a line
// for the first one.
#pragma once
#include <algorithm>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "fuzz/target.h"
#include "image/mask.h"
#include "remote/array_message.h"
#include "remote/blosc_chunk.h"
#include "remote/byte_order.h"
#include "remote/multipart.h"
#include "remote/network_responses.h"

namespace simplexseg::test {

constexpr std::uint64_t kMostFuzzed = 100'000;  ///< bytes of an array

/// First line and the rest.
inline std::pair<std::string, std::string> fuzz_parts(const std::filesystem::path& path) {
  const std::string bytes = small_file(path);
  const std::size_t end = std::min(bytes.find('\n'), bytes.size());
  return {bytes.substr(0, end), bytes.substr(std::min(end + 1, bytes.size()))};
}

/// Unpacks an array, and packs and unpacks it again.
inline void fuzz_array(const std::filesystem::path& path) {
  const ArrayMessage array = unpack_array(small_file(path), kMostFuzzed);
  const ArrayMessage again = unpack_array(pack_array(array.type, array.shape, array.bytes), kMostFuzzed);
  if (again.shape != array.shape || again.bytes != array.bytes) throw std::logic_error("an array changed");
}

/// Decompresses a chunk. Its length is corrected first, because random data would never match it.
inline void fuzz_chunk(const std::filesystem::path& path) {
  std::string chunk = small_file(path);
  std::size_t size = 0;
  if (chunk.size() >= 16) {
    set_little_endian(chunk, 12, static_cast<std::int32_t>(chunk.size()));
    size = std::min<std::size_t>(little_endian<std::uint32_t>(chunk, 4), kMostFuzzed);
  }
  std::vector<std::byte> to(size);
  read_blosc_chunk(chunk, to);
}

inline WebServer fuzz_server() {
  WebServer server;
  server.what = "the server x", server.kind = "a server", server.administrator = "ask its administrator";
  return server;
}

/// Reads a text as each of the responses of a segmentation server. Throws the first Error after all of them.
inline void fuzz_response(const std::filesystem::path& path) {
  const std::string text = small_file(path);
  const WebServer server = fuzz_server();
  detail_of(text);
  info_of_models(text);
  const std::function<void()> reads[] = {[&] { lease_of(server, text); }, [&] { info_of_capabilities(server, text); },
                                         [&] { session_of(server, text); }};
  std::exception_ptr refused;
  int read = 0;
  for (const auto& one : reads) {
    try {
      one();
      ++read;
    } catch (const Error&) {
      refused = std::current_exception();
    }
  }
  if (refused && read == 0) std::rethrow_exception(refused);
}

/// Response with the region of a mask: its header, and its array.
inline void fuzz_region(const std::filesystem::path& path) {
  auto [meta, body] = fuzz_parts(path);
  Mask mask;
  mask.geometry.size = {4, 5, 6};
  mask.voxels.assign(120, 0);
  take_region(fuzz_server(), {200, "", std::move(meta), std::move(body)}, mask);
}

/// Parts of a response, their ends, and whether it is damaged and complete, read in blocks of `block` bytes.
inline std::vector<std::string> fuzz_multipart(const std::string& boundary, const std::string& body,
                                               std::size_t block) {
  std::vector<std::string> parts;
  MultipartReader reader(boundary, {[&] { parts.emplace_back("part "); },
                                    [&](const char* data, std::size_t bytes) { parts.back().append(data, bytes); },
                                    [&](bool complete) { parts.emplace_back(complete ? "complete" : "incomplete"); }});
  for (std::size_t at = 0; at < body.size(); at += block)
    if (!reader.feed(body.data() + at, std::min(block, body.size() - at))) return {"damaged"};
  parts.emplace_back(reader.complete() ? "end" : "no end");
  return parts;
}
/// Response of several parts: its content type, and its body. The parts do not depend on the blocks of the connection.
inline void fuzz_parts_of_response(const std::filesystem::path& path) {
  const auto [type, body] = fuzz_parts(path);
  const std::optional<std::string> boundary = boundary_of(type);
  if (!boundary) throw Error("a response", "it has no boundary", "check the address of the server");
  const auto whole = fuzz_multipart(*boundary, body, std::max<std::size_t>(body.size(), 1));
  for (const std::size_t block : {1, 2, 7, 64})
    if (fuzz_multipart(*boundary, body, block) != whole) throw std::logic_error("parts depend on the blocks");
}

inline const FuzzTarget remote_fuzz_targets[] = {
    {"array", "fuzzed", fuzz_array},
    {"chunk", "fuzzed", fuzz_chunk},
    {"response", "fuzzed", fuzz_response},
    {"region", "fuzzed", fuzz_region},
    {"multipart", "fuzzed", fuzz_parts_of_response},
};

}  // namespace simplexseg::test
