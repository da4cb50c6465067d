// SPDX-License-Identifier: Apache-2.0
#include "io/platform/reader_limits.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <system_error>

namespace simplexseg {

namespace fs = std::filesystem;

namespace {

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

ReaderLimits limits_for_file(const fs::path& file) {
  constexpr double min_bytes_per_second = 1e7;  // far below the speed of parsing
  std::error_code ignored;
  const std::uintmax_t size = fs::file_size(file, ignored);
  ReaderLimits limits;
  if (ignored) return limits;
  limits.memory_bytes += 8 * static_cast<std::size_t>(size);
  limits.cpu_seconds += static_cast<int>(std::min(static_cast<double>(size) / min_bytes_per_second, 1e6));
  return limits;
}

void limit_this_process(const ReaderLimits& limits) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  constexpr int rounding = 2;  // fractions of seconds of both times
  set_soft_limit(RLIMIT_CPU, static_cast<std::uint64_t>(usage.ru_utime.tv_sec + usage.ru_stime.tv_sec + rounding +
                                                        limits.cpu_seconds));
  set_soft_limit(RLIMIT_AS, RLIM_INFINITY);
  if (const std::size_t now = address_space(); now > 0) set_soft_limit(RLIMIT_AS, now + limits.memory_bytes);
}

}  // namespace simplexseg
