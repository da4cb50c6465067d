// SPDX-License-Identifier: Apache-2.0
#include "archive/server.h"

#include <sys/stat.h>

#include <cstdlib>

#include "archive/match.h"
#include "archive/query.h"
#include "io/test_files.h"
#include "remote/credentials.h"

namespace simplexseg {
namespace {

using test::error_of;

class Servers : public test::FolderTest {};

ArchiveServer web(const std::string& url = "https://archive.example/dicom-web") {
  ArchiveServer server;
  server.name = "web", server.url = url;
  return server;
}

TEST_F(Servers, RoundTrip) {
  ArchiveServer first = web(), second = archive_server_at("ORTHANC@localhost:4242");
  first.ca_file = "/etc/ca.pem", first.credentials_variable = "LOGIN", first.timeout_s = 5;
  second.name = "classic \xc3\xa9", second.calling_title = "US";
  const auto file = folder / "made" / "archives.json";
  EXPECT_TRUE(read_archive_servers(file).empty());
  write_archive_servers({first, second}, file);
  EXPECT_EQ(read_archive_servers(file), (std::vector{first, second}));
  EXPECT_EQ(find_archive_server({first, second}, "web"), first);
  EXPECT_EQ(find_archive_server({first}, ""), first);
  EXPECT_NE(error_of([&] {
              find_archive_server({first, second}, "");
            }).find("choose one of: web, classic"),
            std::string::npos);
  EXPECT_NE(error_of([&] {
              write_archive_servers({first, first}, file);
            }).find("two have the name web"),
            std::string::npos);
  EXPECT_EQ(read_archive_servers(file).size(), 2u);
}

TEST_F(Servers, DamagedFilesAreRejected) {
  const std::string head = R"({"simplexseg_archives": 1, "servers": [)";
  for (const char* text :
       {R"({"name": "a"})", R"({"name": "a", "url": "https://x", "host": "y"})", R"({"name": "a", "url": "ftp://x"})",
        R"({"name": "a", "url": "https://x", "password": "p"})", R"({"name": "a", "host": "y", "port": 0})",
        R"({"name": "a", "url": "https://x"}, {"name": "a", "url": "https://y"})", "3"})
    EXPECT_FALSE(error_of([&] { read_archive_servers(write("a.json", head + text + "]}")); }).empty()) << text;
}

TEST_F(Servers, InvalidAddressesAreRejected) {
  EXPECT_EQ(archive_server_at("https://h:8042/x/").url, "https://h:8042/x");
  const ArchiveServer classic = archive_server_at("TITLE@host:104");
  EXPECT_EQ(classic.called_title + " " + classic.host + " " + std::to_string(classic.port), "TITLE host 104");
  for (const char* address :
       {"host", "T@host", "T@host:", "T@host:70000", "T@host:1x", "@host:104", "a title that is long@h:1", "T@a b:1",
        "gopher://x", "https://", "https://a b", "https://h/x?y=1", "https://h/#x", "https://h\n/x",
        "https://u:secret@h/x", "HTTPS://u:secret@h/x"}) {
    const std::string message = error_of([&] { archive_server_at(address); });
    EXPECT_FALSE(message.empty()) << address;
    EXPECT_EQ(message.find("secret"), std::string::npos) << message;
  }
  ArchiveServer open = web("http://archive.example/x");
  require_archive_server(open);
  open.credentials_variable = "LOGIN";
  EXPECT_NE(error_of([&] { require_archive_server(open); }).find("unencrypted"), std::string::npos);
  for (const char* host : {"127.example.org", "localhost.example.org", "1.127.0.0", "[2001:db8::1]"}) {
    open.url = std::string("http://") + host + ":8042/x";
    EXPECT_NE(error_of([&] { require_archive_server(open); }).find("unencrypted"), std::string::npos) << host;
  }
  for (const char* host : {"127.0.0.1", "127.8.9.1", "localhost", "[::1]"}) {
    open.url = std::string("http://") + host + ":8042/x";
    EXPECT_NO_THROW(require_archive_server(open)) << host;
  }
}

TEST_F(Servers, CredentialsAreReadFromTheVariableOrFile) {
  ArchiveServer server = web();
  EXPECT_TRUE(read_credentials(web_server_of(server)).basic.empty());
  server.credentials_variable = "SIMPLEXSEG_TEST_LOGIN";
  ::unsetenv("SIMPLEXSEG_TEST_LOGIN");
  EXPECT_NE(error_of([&] { read_credentials(web_server_of(server)); }).find("not set"), std::string::npos);
  ::setenv("SIMPLEXSEG_TEST_LOGIN", "ann:pass:word", 1);
  EXPECT_EQ(read_credentials(web_server_of(server)).basic, "ann:pass:word");
  ::setenv("SIMPLEXSEG_TEST_LOGIN", "Bearer abc.def", 1);
  EXPECT_EQ(read_credentials(web_server_of(server)).bearer, "abc.def");
  for (const char* bad : {"hidden", ":hidden", "bearer ", "bearer hidden hidden", "ann:hidden\r\nX: y"}) {
    ::setenv("SIMPLEXSEG_TEST_LOGIN", bad, 1);
    const std::string message = error_of([&] { read_credentials(web_server_of(server)); });
    EXPECT_NE(message.find("format of its credentials"), std::string::npos) << bad;
    EXPECT_EQ(message.find("hidden"), std::string::npos) << message;
  }
  ::unsetenv("SIMPLEXSEG_TEST_LOGIN");

  server.credentials_variable.clear();
  server.credentials_file = write("login", "ann:hidden\n");
  for (const mode_t mode : {0644, 0640, 0602}) {
    ::chmod(server.credentials_file.c_str(), mode);
    const std::string message = error_of([&] { read_credentials(web_server_of(server)); });
    EXPECT_NE(message.find("chmod 600"), std::string::npos);
    EXPECT_EQ(message.find("hidden"), std::string::npos);
  }
  ::chmod(server.credentials_file.c_str(), 0600);
  EXPECT_EQ(read_credentials(web_server_of(server)).basic, "ann:hidden");
  server.credentials_file = folder;
  EXPECT_NE(error_of([&] { read_credentials(web_server_of(server)); }).find("not a file"), std::string::npos);
}

TEST(Queries, DatesAreConverted) {
  EXPECT_EQ(dicom_date_range(""), "");
  EXPECT_EQ(dicom_date_range("2024-02-29"), "20240229");
  EXPECT_EQ(dicom_date_range("2024-01-01..2024-12-31"), "20240101-20241231");
  EXPECT_EQ(dicom_date_range("2024-01-01.."), "20240101-");
  EXPECT_EQ(dicom_date_range("..2024-01-01"), "-20240101");
  for (const char* text : {"2023-02-29", "2024-13-01", "20240101", "..", "2024-01-02..2024-01-01", "yesterday",
                           "2024-1-1", "2024-01-01..x", "1900-02-29"})
    EXPECT_FALSE(error_of([&] { dicom_date_range(text); }).empty()) << text;
}

TEST(Queries, OnlyUidsAreValidFileNames) {
  EXPECT_TRUE(is_dicom_uid("1.2.840.10008"));
  for (const std::string& text :
       {std::string(), std::string("."), std::string(".."), std::string("1..2"), std::string("1.2."),
        std::string("1.2/3"), std::string("1.2a"), std::string(65, '1'), std::string("1\0", 2)})
    EXPECT_FALSE(is_dicom_uid(text)) << text;
}

TEST(Queries, PatternsMatchSubstrings) {
  EXPECT_EQ(part_pattern(""), "");
  EXPECT_EQ(part_pattern("doe"), "*doe*");
  EXPECT_EQ(part_pattern("doe^?"), "doe^?");
  ArchiveQuery query;
  query.patient_name = "a\\b";
  EXPECT_FALSE(error_of([&] { require_query(query); }).empty());
  query.patient_name = "doe", query.study = "../x";
  EXPECT_FALSE(error_of([&] { require_query(query); }).empty());
}

}  // namespace
}  // namespace simplexseg
