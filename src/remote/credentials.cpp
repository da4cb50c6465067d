// SPDX-License-Identifier: Apache-2.0
#include "remote/credentials.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>

#include "core/error.h"
#include "core/number_text.h"
#include "core/system_error.h"
#include "io/platform/files.h"
#include "io/platform/header_text.h"

namespace simplexseg {
namespace {

constexpr std::size_t kMaxSecretBytes = 16384;

Error bad_credentials(const WebServer& server, const std::string& why, const std::string& what_to_do) {
  return Error(server.what, why, what_to_do);
}

}  // namespace

std::string read_secret_file(const std::filesystem::path& path, const std::string& what) {
  const std::string where = what + " " + quoted(path);
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) throw Error(where, system_error_text(errno), "check the path");
  // Checks the open descriptor, since the path may be replaced by another file at any time.
  struct stat status {};
  const bool known = ::fstat(descriptor, &status) == 0;
  std::string text(kMaxSecretBytes, '\0');
  const ssize_t count = known && S_ISREG(status.st_mode) && (status.st_mode & 077) == 0
                            ? ::read(descriptor, text.data(), kMaxSecretBytes)
                            : -1;
  ::close(descriptor);
  if (known && !S_ISREG(status.st_mode)) throw Error(where, "it is not a file", "name a file");
  if (known && ((status.st_mode & 077) != 0 || status.st_uid != ::geteuid()))
    throw Error(where, "other users may read or change it", "restrict it to yourself: chmod 600");
  if (count < 0) throw Error(where, "it cannot be read", "check the file");
  text.resize(static_cast<std::size_t>(count));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text;
}

Credentials read_credentials(const WebServer& server) {
  std::string text;
  if (!server.credentials_variable.empty()) {
    const char* const value = std::getenv(server.credentials_variable.c_str());
    if (!value || !*value)
      throw bad_credentials(
          server, "its credentials are in the variable " + one_line(server.credentials_variable) + ", which is not set",
          "set it to USER:PASSWORD or \"bearer TOKEN\"");
    text = value;
  } else if (!server.credentials_file.empty()) {
    text = read_secret_file(server.credentials_file, server.what + ": its credentials cannot be read from");
  } else {
    return {};
  }
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  const bool is_line = std::none_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
  Credentials credentials;
  constexpr std::size_t kWord = 7;  // length of "bearer "
  if (lower_ascii(text.substr(0, kWord)) == "bearer ")
    credentials.bearer = text.substr(kWord);
  else
    credentials.basic = text;
  if (!is_line || (credentials.bearer.empty() && (text.find(':') == std::string::npos || text.front() == ':')) ||
      credentials.bearer.find(' ') != std::string::npos)
    throw bad_credentials(server, "the format of its credentials is unknown",
                          "write USER:PASSWORD or \"bearer TOKEN\" on one line");
  return credentials;
}

}  // namespace simplexseg
