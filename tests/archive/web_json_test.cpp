// SPDX-License-Identifier: Apache-2.0
#include "archive/web_json.h"

#include <gtest/gtest.h>

#include <random>

#include "archive/faults.h"
#include "core/error.h"
#include "io/platform/load_progress.h"
#include "remote/multipart.h"

namespace simplexseg {
namespace {

const char* const kStudies = R"([{"0020000D": {"vr": "UI", "Value": ["1.2.3"]},
  "00100010": {"vr": "PN", "Value": [{"Alphabetic": "Doe^Jane^^Dr"}]}, "00100020": {"vr": "LO", "Value": ["7\n8"]},
  "00081030": {"vr": "LO", "Value": ["Abdomen"]},
  "00080020": {"vr": "DA", "Value": ["20240531"]}, "00080061": {"vr": "CS", "Value": ["CT", "SEG"]},
  "00201206": {"vr": "IS", "Value": [2]}, "00201208": {"vr": "IS", "Value": ["300"]}}])";

ArchiveServer server() {
  ArchiveServer server;
  server.name = "test";
  return server;
}

TEST(WebJson, StudiesAreRead) {
  const std::vector<ArchiveStudy> studies = studies_of_json(server(), kStudies);
  ASSERT_EQ(studies.size(), 1u);
  const ArchiveStudy expected{.uid = "1.2.3",
                              .patient_name = "Doe, Jane, Dr",
                              .patient_id = "7 8",
                              .date = "2024-05-31",
                              .description = "Abdomen",
                              .modalities = {"CT", "SEG"},
                              .series = 2,
                              .instances = 300};
  EXPECT_EQ(studies[0], expected);
  EXPECT_TRUE(studies_of_json(server(), "").empty());
  EXPECT_TRUE(studies_of_json(server(), "[]").empty());
}

TEST(WebJson, RejectionsHaveAReason) {
  const StoreResponse refused =
      store_response_of_json(R"({"00081198": {"Value": [{"00081197": {"Value": [43264]}}, {}]}})");
  EXPECT_EQ(refused.rejected, 2);
  EXPECT_EQ(refused.reason, "A900");
  const StoreResponse changed =
      store_response_of_json(R"({"00081199": {"Value": [{"00081196": {"Value": [45056]}}]}})");
  EXPECT_EQ(changed.rejected, 0);
  EXPECT_FALSE(changed.warning.empty());
  EXPECT_EQ(store_response_of_json("<xml/>").rejected, 0);
}

TEST(WebJson, SeriesAndInstancesAreRead) {
  const char* const text =
      R"([{"0020000E": {"Value": ["1.2.4"]}, "00080018": {"Value": ["1.2.5"]}, "00200011": {"Value": [7]},
    "00080060": {"Value": ["CT"]}, "0008103E": {"Value": ["Thin"]}, "00201209": {"Value": ["12"]}},
    {"0020000E": {"Value": ["../x"]}, "00080018": {"Value": [3.5]}}, 3, {"0020000E": {"Value": ["1.2.6"]}, "00080018": {"Value": []}}])";
  const std::vector<ArchiveSeries> all = series_of_json(server(), text, "1.2.3");
  ASSERT_EQ(all.size(), 2u);
  EXPECT_EQ(all[0].study + " " + all[0].uid + " " + all[0].modality + " " + all[0].description, "1.2.3 1.2.4 CT Thin");
  EXPECT_EQ(all[0].number, 7);
  EXPECT_EQ(all[0].instances, 12);
  EXPECT_EQ(all[1].uid, "1.2.6");
  EXPECT_EQ(all[1].number, 0);
  EXPECT_EQ(all[1].instances, -1);
  EXPECT_EQ(instances_of_json(server(), text), (std::set<std::string>{"1.2.5"}));
  EXPECT_THROW(series_of_json(server(), "{}", "1.2.3"), ArchiveFault);
  EXPECT_THROW(instances_of_json(server(), "no JSON"), ArchiveFault);
}

TEST(WebJson, EachWarningOfAnArchiveIsRead) {
  const auto warning = [](const std::string& code) {
    return store_response_of_json(R"({"00081199": {"Value": [{"00081196": {"Value": [)" + code + "]}}]}}").warning;
  };
  EXPECT_EQ(warning("45056"), "the archive changed some values");
  EXPECT_EQ(warning("45062"), "the archive discarded some attributes");
  EXPECT_EQ(warning("45063"), "the archive reports that the data do not match their SOP class");
  EXPECT_EQ(warning("0"), "");
  EXPECT_EQ(warning("45057"), "");
  // Without a reason of the archive there is none.
  EXPECT_EQ(store_response_of_json(R"({"00081198": {"Value": [{"00081197": {"Value": [0]}}]}})").reason, "");
  EXPECT_EQ(store_response_of_json(R"({"00081198": {"Value": [{"00081197": {"Value": [1]}}]}})").reason, "0001");
}

TEST(ArchiveFaults, CountsAreFromZeroToNineDigits) {
  EXPECT_EQ(count_in("0", -1), 0);
  EXPECT_EQ(count_in("999999999", -1), 999'999'999);
  for (const char* text : {"", "-1", "1000000000", "1.5", "12x", "99999999999999999999"})
    EXPECT_EQ(count_in(text, -7), -7) << text;
}

TEST(ArchiveFaults, ATransferIsCancelledByItsProgress) {
  EXPECT_NO_THROW(report_progress({}, {}));
  EXPECT_NO_THROW(report_progress([](const ArchiveTransfer&) { return true; }, {}));
  EXPECT_THROW(report_progress([](const ArchiveTransfer&) { return false; }, {}), Cancelled);
}

TEST(WebJson, NestingIsLimitedOutsideOfTexts) {
  const auto nested = [](int depth) {
    return std::string(static_cast<std::size_t>(depth), '[') + std::string(static_cast<std::size_t>(depth), ']');
  };
  EXPECT_TRUE(studies_of_json(server(), nested(32)).empty());
  EXPECT_THROW(studies_of_json(server(), nested(33)), ArchiveFault);
  EXPECT_THROW(studies_of_json(server(), std::string(33, '{')), ArchiveFault);
  // Closed brackets, and brackets in a text with an escaped quotation mark, do not count.
  std::string wide = "[";
  for (int n = 0; n < 40; ++n) wide += "[],";
  const std::string text =
      R"({"0020000D": {"Value": ["1.2.3"]}, "00081030": {"Value": ["a\"[{)" + nested(40) + R"("]}}])";
  ASSERT_EQ(studies_of_json(server(), wide + text).size(), 1u);
}

/// Changes single bytes, numbers and pieces of a text.
std::string damaged(std::string bytes, std::mt19937& random) {
  for (unsigned change = 0; change < 1 + random() % 4 && !bytes.empty(); ++change) {
    const std::size_t at = random() % bytes.size();
    if (random() % 2)
      bytes[at] = "\0\xff{}[]\":,9-e"[random() % 12];
    else
      bytes.insert(at, bytes.substr(random() % bytes.size(), random() % 40));
  }
  return bytes;
}

TEST(WebJson, DamagedResponsesAreReadOrRejected) {
  std::mt19937 random(7);
  int refused = 0;
  for (int round = 0; round < 5000; ++round) {
    const std::string text = damaged(kStudies, random);
    try {
      for (const ArchiveStudy& study : studies_of_json(server(), text)) EXPECT_TRUE(is_dicom_uid(study.uid));
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
    store_response_of_json(text);
  }
  EXPECT_GT(refused, 1000);
  EXPECT_LT(refused, 5000);
}

TEST(WebJson, DamagedPartsAreNotLongerThanTheirData) {
  const std::string whole =
      "--frontier\r\nContent-Length: 3\r\n\r\nabc\r\n--frontier\r\n\r\nlonger than that\r\n--frontier--\r\n";
  std::mt19937 random(7);
  for (int round = 0; round < 5000; ++round) {
    const std::string text = damaged(whole, random);
    int open = 0;
    std::size_t count = 0;
    MultipartReader reader("frontier", {[&] { EXPECT_EQ(open++, 0); }, [&](const char*, std::size_t n) { count += n; },
                                        [&](bool) { EXPECT_EQ(open--, 1); }});
    for (std::size_t at = 0; at < text.size(); at += 11)
      reader.feed(text.data() + at, std::min<std::size_t>(11, text.size() - at));
    EXPECT_LE(count, text.size());
    EXPECT_TRUE(!reader.complete() || open == 0);
  }
}

}  // namespace
}  // namespace simplexseg
