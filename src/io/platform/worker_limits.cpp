// SPDX-License-Identifier: Apache-2.0
#include "io/platform/worker_limits.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <system_error>

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

int cpu_seconds = WorkerLimits().cpu_seconds;  // last limit of processor time

/// Returns the size of the address space of this process, bytes; 0 when unknown. It is larger than the memory in use.
std::size_t address_space() {
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void set_soft_limit(__rlimit_resource resource, std::uint64_t value) {
  rlimit limit{};
  ::getrlimit(resource, &limit);
  limit.rlim_cur = std::min<rlim_t>(value, limit.rlim_max);
  ::setrlimit(resource, &limit);
}

}  // namespace

WorkerLimits limits_for_bytes(std::uintmax_t bytes) {
  constexpr double min_bytes_per_second = 1e7;  // far below the speed of parsing
  WorkerLimits limits;
  limits.memory_bytes += 8 * static_cast<std::size_t>(bytes);
  limits.cpu_seconds += static_cast<int>(std::min(static_cast<double>(bytes) / min_bytes_per_second, 1e6));
  return limits;
}

WorkerLimits limits_for_file(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(file, error);
  return limits_for_bytes(error ? 0 : bytes);
}

void limit_this_process(const WorkerLimits& limits) {
  cpu_seconds = limits.cpu_seconds;
  restart_processor_time();
  set_soft_limit(RLIMIT_AS, RLIM_INFINITY);
  if (const std::size_t now = address_space(); now > 0) set_soft_limit(RLIMIT_AS, now + limits.memory_bytes);
}

void restart_processor_time() {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  constexpr int rounding = 2;  // fractions of seconds of both times
  set_soft_limit(RLIMIT_CPU,
                 static_cast<std::uint64_t>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + rounding + cpu_seconds));
}

}  // namespace simplexseg
