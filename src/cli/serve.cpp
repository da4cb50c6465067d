// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <mutex>
#include <ostream>
#include <thread>

#include "app/load.h"
#include "cli/commands.h"
#include "core/error.h"
#include "io/platform/files.h"
#include "remote/credentials.h"
#include "serve/http_server.h"
#include "serve/service.h"

namespace simplexseg {
namespace {

constexpr const char* kTokenVariable = "NN_INTERACTIVE_API_KEY";  // read by clients, too
constexpr std::size_t kLeastToken = 16;                           // characters
constexpr auto kLongestEnd = std::chrono::milliseconds(800);

struct ServeOptions {
  std::string listen = "127.0.0.1", token_file, backend = "auto";
  int port = 1527, threads = 0, most_megabytes = 2048;
  double idle_s = LeaseTimes{}.idle_s, liveness_s = LeaseTimes{}.liveness_s;
  double largest_seed_mm = ServiceSettings{}.largest_seed_mm;
};

volatile std::sig_atomic_t g_ends = 0;

void record_end(int) { g_ends = 1; }

/// Handles SIGINT and SIGTERM during its lifetime.
class EndSignals {
 public:
  EndSignals() {
    g_ends = 0;
    for (std::size_t s = 0; s < std::size(kSignals); ++s) previous_[s] = std::signal(kSignals[s], record_end);
  }
  ~EndSignals() {
    for (std::size_t s = 0; s < std::size(kSignals); ++s) std::signal(kSignals[s], previous_[s]);
  }
  EndSignals(const EndSignals&) = delete;
  EndSignals& operator=(const EndSignals&) = delete;

 private:
  static constexpr int kSignals[2] = {SIGINT, SIGTERM};
  void (*previous_[2])(int);
};

/// Ends the program if its lifetime takes too long: a field that is being solved cannot be stopped at once, and the
/// server has nothing to save.
class LastResort {
 public:
  LastResort()
      : thread_([this] {
          std::unique_lock lock(mutex_);
          if (!ended_.wait_for(lock, kLongestEnd, [this] { return done_; })) std::_Exit(0);
        }) {}
  ~LastResort() {
    {
      const std::lock_guard lock(mutex_);
      done_ = true;
    }
    ended_.notify_one();
    thread_.join();
  }
  LastResort(const LastResort&) = delete;
  LastResort& operator=(const LastResort&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable ended_;
  bool done_ = false;
  std::thread thread_;
};

std::string read_token(const ServeOptions& options) {
  std::string token, source = std::string("the variable ") + kTokenVariable;
  if (!options.token_file.empty()) {
    token = read_secret_file(options.token_file, "the token cannot be read from");
    source = "the file " + quoted(options.token_file);
  } else if (const char* const value = std::getenv(kTokenVariable)) {
    token = value;
    if (token.empty()) return token;
  } else {
    return token;
  }
  const bool is_word = std::ranges::all_of(token, [](unsigned char c) { return c > 0x20 && c < 0x7f; });
  if (token.size() < kLeastToken || !is_word)
    throw Error(
        "the token in " + source,
        "it has fewer than " + std::to_string(kLeastToken) + " characters, or others than letters, digits and signs",
        "make one, for example by: openssl rand -hex 32");
  return token;
}

void serve(const ServeOptions& options, const Console& console) {
  ServiceSettings settings;
  settings.token = read_token(options);
  if (!is_loopback(options.listen) && settings.token.empty())
    throw Error("--listen " + options.listen, "other computers could use the server, and it has no token",
                std::string("add --token-file FILE, or set ") + kTokenVariable);
  settings.times = {options.idle_s, options.liveness_s};
  settings.most_bytes = static_cast<std::uint64_t>(options.most_megabytes) << 20;
  settings.largest_seed_mm = options.largest_seed_mm;
  settings.threads = options.threads;
  const auto make = [&options] { return engine_for(options.backend, options.threads); };
  make();  // fails at once if the backend is not available
  const EndSignals signals;
  SegmentationService service(settings, make);
  auto server = std::make_unique<HttpServer>(service, options.listen, options.port);
  const bool is_ipv6 = options.listen.find(':') != std::string::npos;
  console.out << "listening on http://" << (is_ipv6 ? "[" + options.listen + "]" : options.listen) << ":"
              << server->port() << (settings.token.empty() ? ", without a token" : ", with a token")
              << "; Ctrl+C ends the server" << std::endl;
  for (int tick = 0; g_ends == 0; ++tick) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (tick % 20 == 0) service.expire();
  }
  console.out << "the server has ended" << std::endl;
  const LastResort last_resort;
  server.reset();
}

}  // namespace

void add_serve(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand(
      "serve", "Serves segmentation to plug-ins of other programs, with the protocol of nnInteractive (docs/serve.md)");
  const auto options = std::make_shared<ServeOptions>();
  sub.add_option("--listen", options->listen, "IP address to listen on; others than those of the loopback need a token")
      .not_empty()
      .show_default();
  sub.add_option("--port", options->port, "TCP port; 0: an unused one, which is printed")
      .within(0, 65535)
      .show_default();
  sub.add_option("--token-file", options->token_file,
                 std::string("File with the bearer token that clients must send, readable by you alone; default: the "
                             "variable ") +
                     kTokenVariable + ", or no token")
      .not_empty();
  sub.add_option("--idle-timeout", options->idle_s,
                 "Time without an action of the user after which a client is dropped, s")
      .within(1.0, 86400.0)
      .show_default();
  sub.add_option("--liveness-timeout", options->liveness_s,
                 "Time without any request after which a client is dropped, s")
      .within(1.0, 86400.0)
      .show_default();
  sub.add_option("--max-megabytes", options->most_megabytes, "Largest request, and largest image in memory, MiB")
      .within(1, 65536)
      .show_default();
  sub.add_option("--seed-radius", options->largest_seed_mm,
                 "Largest radius of the seed of a first click, mm; smaller where the image changes nearer to it")
      .within(0.001, 1000.0)
      .show_default();
  sub.add_option("--backend", options->backend,
                 "Processor: cpu, cuda, or auto: CUDA if a device is available, else the CPU")
      .one_of({"auto", "cpu", "cuda"})
      .show_default();
  sub.add_option("--threads", options->threads, "CPU threads; default: all cores").within(1, 1024);
  sub.callback([options, &action] { action = [options](const Console& console) { serve(*options, console); }; });
}

}  // namespace simplexseg
