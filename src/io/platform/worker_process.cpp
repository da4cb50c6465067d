// SPDX-License-Identifier: Apache-2.0
#include "io/platform/worker_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <iterator>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "core/system_error.h"
#include "io/platform/files.h"
#include "io/platform/load_progress.h"
#include "io/platform/packing.h"
#include "io/platform/temporary_folder.h"
#include "io/platform/worker_channel.h"
#include "io/platform/worker_program.h"

namespace simplexseg {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

/// Running worker process. The destructor kills it and deletes its temporary folder.
class WorkerProcess {
 public:
  explicit WorkerProcess(const WorkerProgram& worker);
  ~WorkerProcess() {
    end(std::chrono::seconds(0));
    ::close(socket_);
  }
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  int socket() const { return socket_; }
  /// Returns true when the process waits for a request and will still do so for some seconds.
  bool is_usable() const {
    pollfd request{socket_, POLLIN, 0};
    return Clock::now() < usable_until_ && ::poll(&request, 1, 0) == 0;
  }
  void set_idle() { usable_until_ = Clock::now() + std::chrono::seconds(kWorkerIdleSeconds - 10); }
  /// Waits for the end of the process, and kills it after `patience`. Returns its wait status; nullopt when it was
  /// killed here.
  std::optional<int> end(std::chrono::milliseconds patience);
  /// Closes the socket in a forked copy of the program, where the process belongs to the original.
  void abandon() { ::close(socket_); }

 private:
  TemporaryFolder folder_;
  pid_t id_ = -1;
  int socket_ = -1;
  Clock::time_point usable_until_;
};

namespace {

/// File actions and attributes of posix_spawn().
class SpawnSettings {
 public:
  explicit SpawnSettings(int channel) {
    ::posix_spawn_file_actions_init(&actions);
    ::posix_spawn_file_actions_adddup2(&actions, channel, kWorkerChannel);
    ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDWR, 0);
    ::posix_spawn_file_actions_adddup2(&actions, STDIN_FILENO, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions, STDIN_FILENO, STDERR_FILENO);
    ::posix_spawn_file_actions_addclosefrom_np(&actions, kWorkerChannel + 1);
    ::posix_spawnattr_init(&attributes);
    sigset_t none, all;
    ::sigemptyset(&none);
    ::sigfillset(&all);
    ::posix_spawnattr_setsigmask(&attributes, &none);
    ::posix_spawnattr_setsigdefault(&attributes, &all);
    // The process group of its own keeps Ctrl+C in a terminal away from the process.
    ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  }
  ~SpawnSettings() {
    ::posix_spawn_file_actions_destroy(&actions);
    ::posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawn_file_actions_t actions{};
  posix_spawnattr_t attributes{};
};

std::vector<std::string> environment_with_folder(const std::string& folder) {
  constexpr std::string_view variable = "TMPDIR=";
  std::vector<std::string> all;
  for (char** entry = environ; *entry; ++entry) {
    if (!std::string_view(*entry).starts_with(variable)) all.emplace_back(*entry);
  }
  all.push_back(std::string(variable) + folder);
  return all;
}

/// Idle processes of one worker program.
class WorkerPool {
 public:
  ~WorkerPool() { clear(); }

  /// Returns an idle process; null when there is none. Deletes those that have exited or soon will.
  std::unique_ptr<WorkerProcess> take_idle() {
    Processes unusable;  // deleted after the lock is released
    const std::lock_guard lock(mutex_);
    abandon_in_forked_copy();
    const auto last =
        std::partition(idle_.begin(), idle_.end(), [](const auto& process) { return process->is_usable(); });
    std::move(last, idle_.end(), std::back_inserter(unusable));
    idle_.erase(last, idle_.end());
    if (idle_.empty()) return nullptr;
    std::unique_ptr<WorkerProcess> process = std::move(idle_.back());
    idle_.pop_back();
    return process;
  }

  void release(std::unique_ptr<WorkerProcess> process) {
    process->set_idle();
    const std::lock_guard lock(mutex_);
    abandon_in_forked_copy();
    if (idle_.size() < kMaxIdle) idle_.push_back(std::move(process));
  }

  void clear() {
    Processes all;  // deleted after the lock is released
    const std::lock_guard lock(mutex_);
    abandon_in_forked_copy();
    all.swap(idle_);
  }

 private:
  using Processes = std::vector<std::unique_ptr<WorkerProcess>>;
  static constexpr std::size_t kMaxIdle = 4;

  void abandon_in_forked_copy() {
    if (owner_ == ::getpid()) return;
    for (std::unique_ptr<WorkerProcess>& process : idle_) process.release()->abandon();
    idle_.clear();
    owner_ = ::getpid();
  }

  std::mutex mutex_;
  Processes idle_;
  pid_t owner_ = ::getpid();
};

WorkerPool& pool_of(const WorkerProgram& program) {
  static WorkerPool readers, registers;
  return &program == &kRegisterProgram ? registers : readers;
}

std::unique_ptr<WorkerProcess> new_process(const WorkerProgram& program) {
  try {
    return std::make_unique<WorkerProcess>(program);
  } catch (const WorkerUnavailable&) {
    throw;
  } catch (const Error& error) {  // the program or a temporary folder is missing
    throw WorkerUnavailable(error.what());
  }
}

/// Returns true when a process with this wait status ended whatever file it reads: a user or the system killed it, or
/// it was idle for kWorkerIdleSeconds.
bool ended_without_cause(int status) {
  constexpr std::array signals{SIGKILL, SIGTERM, SIGINT, SIGHUP};
  if (WIFEXITED(status)) return WEXITSTATUS(status) == 0;
  return WIFSIGNALED(status) && std::find(signals.begin(), signals.end(), WTERMSIG(status)) != signals.end();
}

}  // namespace

WorkerProcess::WorkerProcess(const WorkerProgram& worker) {
  const auto fail = [&](int why) {
    const bool is_scarce = why == EAGAIN || why == ENOMEM || why == EMFILE || why == ENFILE;
    throw WorkerUnavailable(std::string("cannot start the program ") + worker.name, system_error_text(why),
                            is_scarce ? "close other programs" : "install SimplexSeg again");
  };
  const fs::path program = path_of_program(worker);
  std::vector<std::string> arguments{program.string(), SIMPLEXSEG_VERSION, folder_.path().string()};
  std::vector<std::string> environment = environment_with_folder(folder_.path().string());
  const auto pointers = [](std::vector<std::string>& texts) {
    std::vector<char*> list;
    list.reserve(texts.size() + 1);
    for (std::string& text : texts) list.push_back(text.data());
    list.push_back(nullptr);
    return list;
  };
  const std::vector<char*> argv = pointers(arguments), envp = pointers(environment);
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) fail(errno);
  socket_ = ends[0];
  const SpawnSettings settings(ends[1]);
  const int why =
      ::posix_spawn(&id_, program.c_str(), &settings.actions, &settings.attributes, argv.data(), envp.data());
  ::close(ends[1]);
  if (why == 0) return;
  ::close(socket_);
  id_ = -1;
  fail(why);
}

std::optional<int> WorkerProcess::end(std::chrono::milliseconds patience) {
  const Clock::time_point until = Clock::now() + patience;
  int status = 0;
  bool killed = false;
  while (id_ > 0) {
    const pid_t ended = ::waitpid(id_, &status, killed ? 0 : WNOHANG);
    if (ended == id_ || (ended < 0 && errno != EINTR)) {
      id_ = -1;
    } else if (ended == 0 && Clock::now() < until) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    } else if (ended == 0) {
      killed = ::kill(id_, SIGKILL) == 0;
    }
  }
  return killed ? std::nullopt : std::optional(status);
}

WorkerRequest::WorkerRequest(std::string packed, fs::path file, const WorkerLimits& limits, WorkerCall call)
    : packed_(std::move(packed)),
      file_(std::move(file)),
      limits_(limits),
      call_(std::move(call)),
      idle_timeout_ms_(1000 * std::min(limits.idle_timeout_s(), 1000000)) {
  process_ = pool_of(call_.program).take_idle();
  can_repeat_ = process_ != nullptr;
  if (!process_) process_ = new_process(call_.program);
  if (!send_request()) repeat_or_fail();
}

WorkerRequest::~WorkerRequest() = default;

bool WorkerRequest::wait(short event) const {
  constexpr int slice_ms = 50;  // latency of a cancellation
  for (int waited_ms = 0; waited_ms < idle_timeout_ms_; waited_ms += slice_ms) {
    check_cancelled();
    pollfd request{process_->socket(), event, 0};
    const int ready = ::poll(&request, 1, slice_ms);
    if (ready > 0) return true;
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool WorkerRequest::send_request() {
  const RequestHead head{.bytes = packed_.size(), .limits = limits_};
  const auto waiting = [this](short event) { return wait(event); };
  return send_bytes(process_->socket(), &head, sizeof head, waiting) &&
         send_bytes(process_->socket(), packed_.data(), packed_.size(), waiting) &&
         std::all_of(call_.attachments.begin(), call_.attachments.end(), [&](std::span<const std::byte> bytes) {
           return send_bytes(process_->socket(), bytes.data(), bytes.size(), waiting);
         });
}

/// Repeats the request by a new process if an idle process ended before it responded; otherwise throws.
void WorkerRequest::repeat_or_fail() {
  const std::unique_ptr<WorkerProcess> process = std::move(process_);
  pollfd closed{process->socket(), POLLIN, 0};
  const bool blocked = ::poll(&closed, 1, 0) == 0;
  const std::optional<int> status = process->end(std::chrono::seconds(blocked ? 0 : 2));
  if (!status || (WIFSIGNALED(*status) && WTERMSIG(*status) == SIGXCPU)) throw WorkerFailure(call_.program.time_limit);
  const std::string what = std::string("cannot ") + call_.program.activity + " " + quoted(file_);
  if (WIFEXITED(*status) && WEXITSTATUS(*status) == kExitOtherVersion)
    throw WorkerUnavailable(what, std::string("the program ") + call_.program.name + " has another version",
                            "install SimplexSeg again");
  if (WIFEXITED(*status) && WEXITSTATUS(*status) == 127)
    throw WorkerUnavailable(what, std::string("the program ") + call_.program.name + " lacks a library",
                            call_.program.remedy);
  if (!ended_without_cause(*status)) throw WorkerFailure(call_.program.crash);
  if (!std::exchange(can_repeat_, false))
    throw WorkerUnavailable(what, std::string(call_.program.process) + " was killed", "try again");
  process_ = new_process(call_.program);
  if (!send_request()) repeat_or_fail();
}

void WorkerRequest::fail_by_garbage() {
  process_.reset();
  throw WorkerFailure(call_.program.crash);
}

void WorkerRequest::receive(void* to, std::size_t bytes) {
  while (!receive_bytes(process_->socket(), to, bytes, [this](short event) { return wait(event); })) repeat_or_fail();
  can_repeat_ = false;
}

/// Receives the head of the next frame and returns the number of its bytes. Throws the failure if the frame contains
/// one, or if it contains data but `data` is false, or the reverse.
std::uint64_t WorkerRequest::next_frame(bool data) {
  constexpr std::uint64_t max_message = 1 << 16;
  if (!process_) throw WorkerFailure("it is damaged (the response of the worker process has ended)");
  FrameHead head;
  for (;;) {
    receive(&head, sizeof head);
    if (head.mark != kFrameMark) fail_by_garbage();
    if (head.kind != FrameKind::Progress) break;
    if (head.bytes > max_message) fail_by_garbage();
    std::string state(head.bytes, '\0');
    receive(state.data(), state.size());
    if (call_.on_progress) call_.on_progress(state);
  }
  if (head.kind == FrameKind::Failure || head.kind == FrameKind::Error) {
    if (head.bytes > max_message) fail_by_garbage();
    std::string text(head.bytes, '\0');
    receive(text.data(), text.size());
    pool_of(call_.program).release(std::move(process_));
    if (head.kind == FrameKind::Error) throw Error(one_line(text, max_message));
    throw WorkerFailure(one_line(text, max_message));
  }
  if (head.kind != (data ? FrameKind::Data : FrameKind::Result)) fail_by_garbage();
  return head.bytes;
}

void WorkerRequest::read(void* to, std::size_t bytes) {
  for (std::size_t done = 0; done < bytes;) {
    if (frame_left_ == 0) frame_left_ = next_frame(true);
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(frame_left_, bytes - done));
    receive(static_cast<char*>(to) + done, count);
    frame_left_ -= count;
    done += count;
  }
}

std::string WorkerRequest::finish() {
  if (frame_left_ > 0) fail_by_garbage();
  const std::uint64_t bytes = next_frame(false);
  if (bytes > limits_.memory_bytes) fail_by_garbage();
  std::string result(bytes, '\0');
  receive(result.data(), result.size());
  pool_of(call_.program).release(std::move(process_));
  return result;
}

void prepare_reader() {
  std::unique_ptr<WorkerProcess> process = pool_of(kReaderProgram).take_idle();
  pool_of(kReaderProgram).release(process ? std::move(process) : new_process(kReaderProgram));
}

void end_idle_workers() {
  for (const WorkerProgram* program : {&kReaderProgram, &kRegisterProgram}) pool_of(*program).clear();
}

}  // namespace simplexseg
