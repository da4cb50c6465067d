// SPDX-License-Identifier: Apache-2.0
// Responses of segmentation servers: what is read, and one line for everything else.
#include "remote/network_responses.h"

#include <gtest/gtest.h>

#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "core/error.h"
#include "remote/array_message.h"

namespace simplexseg {
namespace {

WebServer response_server() {
  WebServer server;
  server.what = "the server x", server.kind = "a server", server.administrator = "ask its administrator";
  return server;
}

/// Line of the RemoteFault that f throws.
std::string remote_line(const std::function<void()>& f) {
  try {
    f();
  } catch (const RemoteFault& fault) {
    const std::string text = fault.what();
    EXPECT_EQ(text.find_first_of("\n\r\t"), std::string::npos) << text;
    return text;
  }
  return "no fault";
}
#define EXPECT_FAULT(statement, part) \
  EXPECT_NE(remote_line([&] { statement; }).find(part), std::string::npos) << remote_line([&] { statement; })

TEST(NetworkResponses, ALeaseHasATokenAndABeat) {
  const WebServer server = response_server();
  const NetworkLease lease = lease_of(server, R"({"lease_token": "abc-1", "liveness_timeout_seconds": 60})");
  EXPECT_EQ(lease.token, "abc-1");
  EXPECT_EQ(lease.beat_s, 30);
  EXPECT_EQ(lease_of(server, R"({"lease_token": "a"})").beat_s, 20);
  EXPECT_EQ(lease_of(server, R"({"lease_token": "a", "liveness_timeout_seconds": "soon"})").beat_s, 20);
  EXPECT_EQ(lease_of(server, R"({"lease_token": "a", "liveness_timeout_seconds": -1e300})").beat_s, 0.5);
  EXPECT_EQ(lease_of(server, R"({"lease_token": "a", "liveness_timeout_seconds": 1e300})").beat_s, 600);
  EXPECT_EQ(lease_of(server, R"({"lease_token": ")" + std::string(200, '~') + R"("})").token.size(), 200u);
  EXPECT_FAULT(lease_of(server, ""), "it is not a JSON object");
  EXPECT_FAULT(lease_of(server, "[1]"), "it is not a JSON object");
  EXPECT_FAULT(lease_of(server, "{}"), "it has no lease");
  EXPECT_FAULT(lease_of(server, R"({"lease_token": 7})"), "it has no lease");
  // A token becomes a header of requests.
  for (const std::string& token : {std::string(), std::string(201, 'a'), std::string("a b"),
                                   std::string("a\\r\\nHost: x"), std::string("\\u007f"), std::string("\\u00e9")})
    EXPECT_FAULT(lease_of(server, R"({"lease_token": ")" + token + R"("})"), "its lease is not a text");
}

TEST(NetworkResponses, CapabilitiesAreRead) {
  const WebServer server = response_server();
  const NetworkInfo info = info_of_capabilities(
      server,
      R"({"license": "CC\nBY", "supported_interactions": {"points": true, "box": false, "lasso": true, "x": 1}})");
  EXPECT_EQ(info.networks, std::vector<std::string>{"nnInteractive"});
  EXPECT_EQ(info.inputs, (std::vector<std::string>{"lasso", "points"}));
  EXPECT_EQ(info.licence, "CC BY");
  EXPECT_EQ(info_of_capabilities(server, R"({"license": "!!MISSING!!"})").licence, "");
  EXPECT_EQ(info_of_capabilities(server, R"({"license": 3, "supported_interactions": [true]})").inputs.size(), 0u);
  EXPECT_FAULT(info_of_capabilities(server, "null"), "it is not a JSON object");
  EXPECT_FAULT(info_of_capabilities(server, R"({"supported_interactions": {"points": false}})"),
               "does not accept points");
  // A value of another type is no statement.
  EXPECT_TRUE(info_of_capabilities(server, R"({"supported_interactions": {"points": "no"}})").inputs.empty());
}

TEST(NetworkResponses, ModelsWithPointsComeFirst) {
  const auto info = info_of_models(
      R"({"models": {"a": {"type": "segmentation"}, "b": {"type": "deepgrow"}, "c": 3, "d": {"type": "vista3d"}, "e": {"type": "deepedit"}, "f": {"type": 1}}, "license": "MIT"})");
  ASSERT_TRUE(info);
  EXPECT_EQ(info->protocol, NetworkInfo::Protocol::MonaiLabel);
  EXPECT_EQ(info->networks, (std::vector<std::string>{"b", "d", "e", "a", "c", "f"}));
  EXPECT_EQ(info->licence, "MIT");
  for (const char* text : {"", "3", "{}", R"({"models": []})"}) EXPECT_FALSE(info_of_models(text)) << text;
  EXPECT_EQ(info_of_models(R"({"models": {}})")->licence, "");
}

TEST(NetworkResponses, SessionsAndDetailsAreTexts) {
  const WebServer server = response_server();
  EXPECT_EQ(session_of(server, R"({"session_id": "s"})"), "s");
  for (const char* text : {"", "[]", "{}", R"({"session_id": 4})"})
    EXPECT_FAULT(session_of(server, text), "has no session");
  EXPECT_EQ(detail_of(R"({"detail": "line\nbreak"})"), "line break");
  EXPECT_EQ(detail_of(R"({"detail": ")" + std::string(500, 'a') + R"("})"), std::string(200, 'a') + " ...");
  for (const char* text : {"", "3", "{}", R"({"detail": [1]})"}) EXPECT_EQ(detail_of(text), "") << text;
}

/// Mask after a response with this header and an array of this type and shape, whose bytes are 1, 2, 3 ...
std::vector<std::uint8_t> region_of(const std::string& meta, ArrayType type = ArrayType::UInt8,
                                    const std::vector<std::int64_t>& shape = {1, 2, 3}) {
  std::vector<std::byte> bytes(bytes_of(type));
  for (const std::int64_t size : shape) bytes.resize(bytes.size() * static_cast<std::size_t>(size));
  for (std::size_t n = 0; n < bytes.size(); ++n) bytes[n] = static_cast<std::byte>(n % 2);
  Mask mask;
  mask.geometry.size = {4, 5, 6};
  mask.voxels.assign(120, 0);
  take_region(response_server(), {200, "", meta, pack_array(type, shape, bytes)}, mask);
  return mask.voxels;
}
std::string meta_of(const std::string& box) { return R"({"ran_prediction": true, "bbox": )" + box + "}"; }

TEST(NetworkResponses, ARegionIsWrittenToItsPlace) {
  // k 5, j 3 and 4, i 1 to 3: the last voxels of the image.
  const std::vector<std::uint8_t> voxels = region_of(meta_of("[[5, 6], [3, 5], [1, 4]]"));
  std::vector<std::uint8_t> expected(120, 0);
  for (const int at : {(5 * 5 + 3) * 4 + 2, (5 * 5 + 4) * 4 + 1, (5 * 5 + 4) * 4 + 3})
    expected[static_cast<std::size_t>(at)] = 1;
  EXPECT_EQ(voxels, expected);
  EXPECT_EQ(region_of(meta_of("[[0, 6], [0, 5], [0, 4]]"), ArrayType::Bool, {6, 5, 4})[119], 1);
  EXPECT_EQ(region_of(meta_of("null")), std::vector<std::uint8_t>(120, 0));
  EXPECT_EQ(region_of(R"({"ran_prediction": true})"), std::vector<std::uint8_t>(120, 0));
}

TEST(NetworkResponses, DamagedRegionsAreRefused) {
  EXPECT_FAULT(region_of(""), "it is not a JSON object");
  // A value of another type than a Boolean is no prediction, and no exception of the JSON library.
  for (const char* meta :
       {"{}", R"({"ran_prediction": false})", R"({"ran_prediction": "yes"})", R"({"ran_prediction": 1})"})
    EXPECT_FAULT(region_of(meta), "there was no prediction");
  for (const char* box : {"3", "[]", "[[0, 1], [0, 2]]", "[[0, 1], [0, 2], 3]", "[[0, 1], [0, 2], [3]]",
                          "[[0, 1], [0, 2], [0, 3, 4]]", "[[0, 1], [0, 2], [0, 3.5]]", "[[0, 1], [0, 2], [\"0\", 3]]"})
    EXPECT_FAULT(region_of(meta_of(box)), "not three ranges");
  // Also numbers whose difference overflows.
  for (const char* box :
       {"[[0, 1], [0, 2], [2, 5]]", "[[6, 7], [0, 2], [0, 3]]", "[[-1, 0], [0, 2], [0, 3]]", "[[0, 1], [0, 6], [0, 3]]",
        "[[0, 1], [2, 2], [0, 3]]", "[[0, 1], [4, 2], [0, 3]]",
        "[[-9223372036854775808, 9223372036854775807], [0, 2], [0, 3]]",
        "[[9223372036854775807, -9223372036854775808], [0, 2], [0, 3]]", "[[0, 18446744073709551615], [0, 2], [0, 3]]"})
    EXPECT_FAULT(region_of(meta_of(box)), "outside the image");
  const std::string meta = meta_of("[[0, 1], [0, 2], [0, 3]]");
  EXPECT_FAULT(region_of(meta, ArrayType::UInt8, {1, 3, 2}), "not the shape of its region");
  EXPECT_FAULT(region_of(meta, ArrayType::UInt8, {2, 3}), "not the shape of its region");
  EXPECT_FAULT(region_of(meta, ArrayType::Int16), "the type int16");
  EXPECT_FAULT(region_of(meta, ArrayType::UInt8, {1, 7, 7}), "larger than 48 bytes");
}

}  // namespace
}  // namespace simplexseg
