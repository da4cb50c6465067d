// SPDX-License-Identifier: Apache-2.0
// Worker process simplexseg-reader: protocol, failures, limits, and kill during loads.
#include "io/platform/worker_process.h"

#include <dirent.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "../reader/test_requests.h"
#include "dicom_files.h"
#include "io/dicom/dicom_folder.h"
#include "io/platform/load_progress.h"
#include "io/platform/packing.h"
#include "io/platform/worker_program.h"
#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::error_of;

/// Returns the ids of running worker processes of this process.
std::vector<pid_t> workers() {
  std::vector<pid_t> found;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    std::ifstream stat(entry.path() / "stat");
    std::string text;
    std::getline(stat, text);
    const std::size_t end = text.rfind(')');  // "id (name) state parent ..."
    if (end == std::string::npos || text.find("(simplexseg") == std::string::npos) continue;
    if (text[end + 2] != 'Z' && std::atoi(text.c_str() + end + 4) == ::getpid()) found.push_back(std::stoi(name));
  }
  return found;
}

/// Kills all worker processes of this process.
void kill_workers() {
  for (const pid_t id : workers()) ::kill(id, SIGKILL);
}

/// Returns 8 x 8 pixels of one value in RLE (PS3.5, annex G): a segment of the high bytes and one of the low bytes.
std::string rle_frame(std::uint16_t value) {
  const auto segment = [](int byte) {
    std::string rows;
    for (int row = 0; row < 8; ++row) rows += {'\xf9', static_cast<char>(byte)};  // 8 equal bytes
    return rows;
  };
  std::string head = test::bytes_of_numbers<std::uint32_t, std::uint32_t, std::uint32_t>(2, 64, 64 + 16);
  head.resize(64, '\0');
  return head + segment(value >> 8) + segment(value & 0xff);
}

/// Folder for temporary files of the worker processes, and worker processes of a program.
class ReaderFixture : public test::FolderTest {
 protected:
  explicit ReaderFixture(const char* program = nullptr) {
    end_idle_workers();
    fs::create_directories(temporary);
    const char* const before = std::getenv("TMPDIR");
    before_ = before ? before : "";
    ::setenv("TMPDIR", temporary.c_str(), 1);
    if (program) ::setenv("SIMPLEXSEG_READER", program, 1);
  }
  ~ReaderFixture() override {
    end_idle_workers();
    before_.empty() ? ::unsetenv("TMPDIR") : ::setenv("TMPDIR", before_.c_str(), 1);
    ::unsetenv("SIMPLEXSEG_READER");
  }

  /// Writes a series of `count` slices; the value of each voxel is the number of its slice.
  fs::path make_series(int count, bool compressed = false) {
    const fs::path series = folder / (compressed ? "compressed" : "series");
    fs::create_directories(series);
    for (int k = 0; k < count; ++k) {
      test::DicomData data;
      data.text(0x0008, 0x0016, "UI", "1.2.840.10008.5.1.4.1.1.4")
          .text(0x0008, 0x0018, "UI", "1.2.3." + std::to_string(k + 1));
      data.text(0x0008, 0x0060, "CS", "MR").text(0x0020, 0x000e, "UI", "1.2.3");
      data.numbers(0x0020, 0x0032, {0, 0, double(k)}).numbers(0x0020, 0x0037, {1, 0, 0, 0, 1, 0});
      test::describe_pixels(data, 8, 8, 0);
      data.numbers(0x0028, 0x0030, {1, 1});
      const auto value = static_cast<std::uint16_t>(k);
      std::string pixels;
      for (int v = 0; v < 64; ++v) pixels += test::bytes_of_numbers(value);
      compressed ? data.fragments({rle_frame(value)}) : data.raw(0x7fe0, 0x0010, "OW", pixels);
      std::ofstream(series / (std::to_string(k) + ".dcm"), std::ios::binary)
          << test::dicom_file(data.bytes, "1.2.840.10008.5.1.4.1.1.4", compressed ? test::kRle : test::kExplicitLittle);
    }
    return series;
  }

  fs::path temporary = folder / "temporary";

 private:
  std::string before_;
};

class ReaderProcessTest : public ReaderFixture {
 protected:
  ReaderProcessTest() : ReaderFixture(SIMPLEXSEG_TEST_READER) {}

  std::string failure_of(const std::string& manner, const WorkerLimits& limits = {}) {
    try {
      return request_result(test::kFail, "file", limits, manner);
    } catch (const WorkerFailure& failure) {
      return std::string("failure: ") + failure.what();
    } catch (const Error& error) {
      return std::string("error: ") + error.what();
    }
  }
};

TEST_F(ReaderProcessTest, OneProcessServesManyRequests) {
  for (int n = 0; n < 100; ++n)
    EXPECT_EQ(request_result(test::kEcho, "file", {}, std::to_string(n)), std::to_string(n));
  EXPECT_EQ(workers().size(), 1u);
  end_idle_workers();
  EXPECT_TRUE(workers().empty());
}

TEST_F(ReaderProcessTest, LargeArgumentsAndStreamsArriveInOrder) {
  const std::string text(5000000, 'b');
  EXPECT_EQ(request_result(test::kEcho, "file", {}, text), text);
  WorkerRequest stream(packed_request(test::kSend, "file", 5000000, "none"), "file", {});
  std::string bytes(5000000, '\0');
  stream.read(bytes.data(), 17);
  stream.read(bytes.data() + 17, bytes.size() - 17);
  EXPECT_EQ(bytes, std::string(bytes.size(), 'a'));
  EXPECT_EQ(stream.finish(), "");
}

TEST_F(ReaderProcessTest, ACrashEndsOnlyTheProcessOfTheRequest) {
  for (const char* manner : {"abort", "crash", "exit"}) {
    EXPECT_EQ(failure_of(manner), "failure: it is damaged (the library that reads it failed)") << manner;
    EXPECT_EQ(failure_of("none"), "still running");
  }
}

TEST_F(ReaderProcessTest, ExceptionsBecomeFailuresAndTheProcessRemains) {
  EXPECT_EQ(failure_of("none"), "still running");
  const std::vector<pid_t> before = workers();
  EXPECT_EQ(failure_of("throw"), "failure: its own reason");
  EXPECT_EQ(failure_of("throw number"), "failure: it is damaged (the library that reads it failed)");
  EXPECT_EQ(failure_of("error"), "error: cannot read it: a cause; do this");
  EXPECT_EQ(failure_of("memory"), "failure: it is damaged (reading it exceeds the limit of memory)");
  EXPECT_EQ(failure_of("print"), "still running");
  EXPECT_EQ(workers(), before);
}

TEST_F(ReaderProcessTest, InvalidResponsesAreFailures) {
  for (const char* manner : {"garbage", "large"})
    EXPECT_EQ(failure_of(manner), "failure: it is damaged (the library that reads it failed)") << manner;
  const std::string other = packed(std::string("text"));
  EXPECT_THROW(unpacked<bool>(other), BadPacking);
  EXPECT_THROW(unpacked<std::vector<std::string>>(packed(std::uint64_t(1) << 60)), BadPacking);
  EXPECT_THROW(unpacked<std::vector<double>>(packed(std::uint64_t(1) << 61)), BadPacking);
  EXPECT_THROW(unpacked<std::string>(other + "x"), BadPacking);
  for (std::size_t length = 0; length < other.size(); ++length)
    EXPECT_THROW(unpacked<std::string>(std::string_view(other).substr(0, length)), BadPacking);
}

TEST_F(ReaderProcessTest, AKilledProcessIsNotAFaultOfTheFile) {
  EXPECT_EQ(failure_of("kill"), "error: cannot read 'file': the process that reads it was killed; try again");
  EXPECT_EQ(failure_of("none"), "still running");
  kill_workers();
  EXPECT_EQ(failure_of("none"), "still running") << "an idle process that was killed is replaced";
}

/// A process that is killed in a stream has already responded, so the request is not repeated.
TEST_F(ReaderProcessTest, AKillInAStreamIsAnError) {
  EXPECT_EQ(failure_of("none"), "still running");
  WorkerRequest stream(packed_request(test::kSend, "file", 1000, "kill"), "file", {});
  std::string bytes(1000, '\0');
  stream.read(bytes.data(), bytes.size());
  EXPECT_HAS(error_of([&] { stream.finish(); }), "the process that reads it was killed; try again");
}

TEST_F(ReaderProcessTest, MemoryAndTimeAreLimitedForEachRequest) {
  const auto takes = [](std::uint64_t mb, const WorkerLimits& limits = {}) {
    return request_result(test::kAllocate, "file", limits, mb << 20);
  };
  EXPECT_TRUE(takes(100));
  EXPECT_FALSE(takes(400));
  EXPECT_TRUE(takes(400, {.memory_bytes = 600 << 20}));
  EXPECT_FALSE(takes(400));
  EXPECT_EQ(failure_of("loop", {.cpu_seconds = 0}), "failure: it is damaged (reading it exceeds the limit of time)");
  EXPECT_EQ(failure_of("sleep", {.cpu_seconds = 0, .min_idle_timeout_s = 1}),
            "failure: it is damaged (reading it exceeds the limit of time)");
}

/// The headers of a folder are read by one request. The test program crashes for files that begin with "crash".
TEST_F(ReaderProcessTest, ACrashOmitsOnlyOneFileOfAFolder) {
  const fs::path series = make_series(150);
  for (const char* name : {"100", "149", "70"})
    fs::rename(series / (std::string(name) + ".dcm"), series / (std::string("crash") + name));
  const DicomScan scan = scan_for_dicom({series}, false);
  ASSERT_EQ(scan.series.size(), 1u);
  EXPECT_EQ(scan.series.begin()->second.size(), 147u);
  ASSERT_EQ(scan.unreadable.size(), 3u);
  for (const UnreadableEntry& entry : scan.unreadable) {
    EXPECT_HAS(entry.path.filename().string(), "crash");
    EXPECT_EQ(entry.reason, "it is damaged (the library that reads it failed)");
  }
}

TEST_F(ReaderProcessTest, TemporaryFilesAreDeletedWithTheProcess) {
  const fs::path file = request_result(test::kLeaveFile, "file", {});
  EXPECT_TRUE(fs::exists(file));
  EXPECT_EQ(failure_of("kill").substr(0, 6), "error:");
  EXPECT_FALSE(fs::exists(file));
  request_result(test::kLeaveFile, "file", {});
  end_idle_workers();
  EXPECT_TRUE(fs::is_empty(temporary));
}

TEST_F(ReaderProcessTest, ACancellationKillsTheProcess) {
  LoadProgress progress;
  bool cancelled = false;
  std::jthread reader([&] {
    const LoadProgress::Scope scope(progress);
    try {
      failure_of("sleep");
    } catch (const Cancelled&) {
      cancelled = true;
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(200));
  progress.cancel();
  reader.join();
  EXPECT_TRUE(cancelled);
  EXPECT_TRUE(workers().empty());
  EXPECT_TRUE(fs::is_empty(temporary));
}

TEST_F(ReaderProcessTest, ThreadsUseSeveralProcesses) {
  std::atomic<int> right = 0;
  {
    std::vector<std::jthread> threads;
    for (int t = 0; t < 4; ++t)
      threads.emplace_back([&, t] {
        for (int n = 0; n < 50; ++n) {
          const std::string text = std::to_string(1000 * t + n);
          right += request_result(test::kEcho, "file", {}, text) == text;
        }
      });
  }
  EXPECT_EQ(right, 200);
}

/// The processes of the original are not used by a copy that fork() makes, for example in a Python pool.
TEST_F(ReaderProcessTest, AForkedCopyStartsItsOwnProcess) {
  EXPECT_EQ(failure_of("none"), "still running");
  const pid_t copy = ::fork();
  if (copy == 0) {
    const bool right = failure_of("none") == "still running" && workers().size() == 1;
    end_idle_workers();
    ::_exit(right ? 0 : 1);
  }
  int status = 0;
  ::waitpid(copy, &status, 0);
  EXPECT_EQ(status, 0);
  EXPECT_EQ(failure_of("none"), "still running");
  EXPECT_EQ(workers().size(), 1u);
}

/// Without the program there is one message, whatever the number of files.
TEST_F(ReaderProcessTest, AMissingProgramIsOneError) {
  ::setenv("SIMPLEXSEG_READER", (folder / "missing").c_str(), 1);
  EXPECT_EQ(failure_of("none"), "error: cannot start the program simplexseg-reader, which reads DICOM and MINC: '" +
                                    (folder / "missing").string() +
                                    "' is not a program; correct the environment variable SIMPLEXSEG_READER");
}

// ---- loads with the real program ----

class ReaderKills : public ReaderFixture {};

/// A kill before the response to a request is not noticed; otherwise the load fails with one line.
TEST_F(ReaderKills, TheNextLoadSucceedsAfterKillsAtRandomMoments) {
  constexpr int slices = 200;
  std::mt19937 random(7);
  for (const bool compressed : {false, true}) {
    const fs::path series = make_series(slices, compressed);
    const auto load = [&] {
      const LoadedVolume loaded = load_volume(series);
      EXPECT_EQ(loaded.volume.geometry().size[2], slices);
      EXPECT_EQ(loaded.volume.value(3, 3, slices - 1), slices - 1);
      EXPECT_TRUE(loaded.warnings.empty());
    };
    load();
    const auto begin = std::chrono::steady_clock::now();
    load();
    const auto duration = std::chrono::steady_clock::now() - begin;
    for (int round = 0; round < 20; ++round) {
      std::string message;
      std::jthread reader([&] {
        try {
          load();
        } catch (const Error& error) {
          message = error.what();
        }
      });
      std::this_thread::sleep_for(duration * (random() % 1000) / 1000);
      kill_workers();
      reader.join();
      if (!message.empty()) {
        EXPECT_HAS(message, "the process that reads it was killed; try again");
        EXPECT_EQ(message.find('\n'), std::string::npos);
      }
      load();
    }
  }
  end_idle_workers();
  EXPECT_TRUE(fs::is_empty(temporary));
  EXPECT_TRUE(workers().empty());
}

TEST_F(ReaderKills, ASeriesIsReadByOneProcess) {
  const fs::path series = make_series(30);
  std::set<pid_t> ids;
  std::atomic<bool> done = false;
  std::jthread observer([&] {
    while (!done)
      for (const pid_t id : workers()) ids.insert(id);
  });
  load_volume(series);
  load_volume(series);
  for (const pid_t id : workers()) ids.insert(id);
  done = true;
  observer.join();
  EXPECT_EQ(ids.size(), 1u);
}

/// The process and its temporary folder do not outlive a program that was killed.
TEST_F(ReaderKills, TheProcessEndsWithTheProgram) {
  const fs::path series = make_series(3);
  const pid_t program = ::fork();
  if (program == 0) {
    load_volume(series);
    ::kill(::getpid(), SIGKILL);
  }
  int status = 0;
  ::waitpid(program, &status, 0);
  EXPECT_TRUE(WIFSIGNALED(status));
  for (int n = 0; n < 500 && !fs::is_empty(temporary); ++n) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_TRUE(fs::is_empty(temporary));
}

}  // namespace
}  // namespace simplexseg
