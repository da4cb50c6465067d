// SPDX-License-Identifier: Apache-2.0
// Stand-in for segmentation servers (stand_in.py) in a process of its own, for the tests of calls and of the window.
#pragma once
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "remote/http_client.h"
#include "remote/network_server.h"

extern char** environ;

namespace simplexseg::test {

inline constexpr const char* kPython = "/usr/bin/python3";

/// Whether the stand-in can run.
inline bool has_blosc() { return std::system((std::string(kPython) + " -c 'import blosc' 2>/dev/null").c_str()) == 0; }

/// Process of a stand-in, which ends with this object.
class StandInProcess {
 public:
  /// `fault`, `token`: see stand_in.py.
  explicit StandInProcess(const std::string& protocol, const std::string& fault = "", const std::string& token = "") {
    int ends[2];
    if (::pipe(ends) != 0) return;
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 1);
    const std::string script = std::string(SIMPLEXSEG_SOURCE_DIR) + "/tests/remote/stand_in.py";
    std::vector<std::string> words{kPython, "-B", script, protocol, fault, token};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (::posix_spawn(&id_, kPython, &actions, nullptr, arguments.data(), environ) != 0) id_ = 0;
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    for (char c = 0; ::read(ends[0], &c, 1) == 1 && c != '\n';) port_ += c;
    ::close(ends[0]);
  }
  ~StandInProcess() { end(); }
  StandInProcess(const StandInProcess&) = delete;
  StandInProcess& operator=(const StandInProcess&) = delete;

  void end() {
    if (id_ > 0) ::kill(id_, SIGKILL), ::waitpid(id_, nullptr, 0);
    id_ = 0;
  }
  std::string url() const { return "http://127.0.0.1:" + port_; }
  /// Methods and paths of all requests so far, separated by blanks.
  std::string requests() const {
    return HttpClient(web_server_of(server())).send({"GET", "/stand-in/requests", "*/*", {}, "", ""}, [] {}).body;
  }
  NetworkServer server() const { return find_network_server({}, url()); }

 private:
  ::pid_t id_ = 0;
  std::string port_;
};

}  // namespace simplexseg::test
