// SPDX-License-Identifier: Apache-2.0
#include "remote/web_server.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "io/test_files.h"

namespace simplexseg {
namespace {

WebServer web_server_at(const std::string& url) {
  WebServer server;
  server.what = "the server x", server.kind = "a server", server.url = url;
  return server;
}
/// Message of the refusal of a server; "" if it is accepted.
std::string refusal_of(const WebServer& server) {
  try {
    require_web_server(server, "https://host:1");
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(WebServers, AddressesAreChecked) {
  for (const char* url : {"https://h", "http://h:1/x", "https://[2001:db8::1]:8042/x", "https://h/a@b"})
    EXPECT_EQ(refusal_of(web_server_at(url)), "") << url;
  EXPECT_HAS(refusal_of(web_server_at("")), "it has no URL");
  for (const char* url : {"ftp://h", "HTTP://h", "h:1", "//h"})
    EXPECT_HAS(refusal_of(web_server_at(url)), "does not begin with https:// or http://");
  for (const char* url : {"https://", "https://a b", "https://h/?q=1", "https://h/#x", "https://h\n/x", "https://h%00"})
    EXPECT_HAS(refusal_of(web_server_at(url)), "its URL is invalid");
}

TEST(WebServers, APasswordInAnAddressIsRefusedWithoutTheAddress) {
  for (const char* url : {"https://u:secret@h/x", "HTTPS://u:secret@h", "u:secret@h", "//u:secret@h?x"}) {
    WebServer server = web_server_at(url);
    server.what = std::string("the server ") + url;
    const std::string message = refusal_of(server);
    EXPECT_HAS(message, "it contains a user or a password");
    EXPECT_EQ(message.find("secret"), std::string::npos) << message;
  }
}

TEST(WebServers, CredentialsGoToThisMachineOrOverHttps) {
  const auto with_credentials = [](const std::string& url) {
    WebServer server = web_server_at(url);
    server.credentials_variable = "LOGIN";
    return refusal_of(server);
  };
  for (const char* host : {"h", "127.example.org", "localhost.example.org", "1.127.0.0", "[2001:db8::1]", "0.0.0.0"}) {
    EXPECT_HAS(with_credentials(std::string("http://") + host + ":8042/x"), "unencrypted");
    EXPECT_EQ(with_credentials(std::string("https://") + host + ":8042/x"), "") << host;
    EXPECT_EQ(refusal_of(web_server_at(std::string("http://") + host)), "") << host;
  }
  for (const char* host : {"127.0.0.1", "127.8.9.1", "localhost", "[::1]"})
    EXPECT_EQ(with_credentials(std::string("http://") + host + ":8042/x"), "") << host;
}

TEST(WebServers, SettingsAreChecked) {
  const auto refused = [](WebServer server, const std::string& name) {
    try {
      require_server_settings(server, name);
      return std::string();
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  WebServer server = web_server_at("https://h/" + std::string(100, 'x'));
  EXPECT_EQ(refused(server, std::string(64, 'n')), "");
  EXPECT_EQ(refused(server, server.url), "");
  for (const std::string& name : {std::string(), std::string(65, 'n'), std::string(" n"), std::string("n\n")})
    EXPECT_HAS(refused(server, name), "its name is empty, too long or has blanks at its ends");
  for (const int seconds : {1, 3600}) {
    server.timeout_s = seconds;
    EXPECT_EQ(refused(server, "n"), "");
  }
  for (const int seconds : {0, 3601}) {
    server.timeout_s = seconds;
    EXPECT_HAS(refused(server, "n"), "use 1 to 3600 s");
  }
  server.timeout_s = 30, server.credentials_file = "a";
  EXPECT_EQ(refused(server, "n"), "");
  server.credentials_variable = "A";
  EXPECT_HAS(refused(server, "n"), "both a variable and a file");
}

TEST(WebServers, ThisMachineIsRecognisedByItsAddress) {
  for (const char* host : {"localhost", "127.0.0.1", "127.255.0.9", "::1", "[::1]"}) EXPECT_TRUE(is_own_host(host));
  for (const char* host : {"", "[]", "127.x", "128.0.0.1", "10.127.0.1", "::2", "127.0.0.1.example.org"})
    EXPECT_FALSE(is_own_host(host)) << host;
}

}  // namespace
}  // namespace simplexseg
