// SPDX-License-Identifier: Apache-2.0
// Fuzzer for all targets; the environment variable SIMPLEXSEG_FUZZ_TARGET selects one (see scripts/fuzz).
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "fuzz/archive_targets.h"
#include "fuzz/remote_targets.h"
#include "fuzz/serve_targets.h"
#include "fuzz/targets.h"

namespace {

namespace fs = std::filesystem;
using simplexseg::test::FuzzTarget;

std::vector<FuzzTarget> all_targets() {
  std::vector<FuzzTarget> all;
  const auto add = [&](const auto& targets) { all.insert(all.end(), std::begin(targets), std::end(targets)); };
  add(simplexseg::test::fuzz_targets);
  add(simplexseg::test::remote_fuzz_targets);
  add(simplexseg::test::archive_fuzz_targets);
  add(simplexseg::test::serve_fuzz_targets);
  return all;
}

FuzzTarget target_named(const char* name) {
  const std::vector<FuzzTarget> all = all_targets();
  for (const FuzzTarget& target : all) {
    if (name && std::string(name) == target.name) return target;
  }
  std::fprintf(stderr, "fuzz: SIMPLEXSEG_FUZZ_TARGET must be one of");
  for (const FuzzTarget& target : all) std::fprintf(stderr, " %s", target.name);
  std::fprintf(stderr, "\n");
  std::exit(2);
}

/// Temporary folder of this process, in a memory file system if there is one.
struct Folder {
  fs::path path = (fs::is_directory("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path()) /
                  ("simplexseg-fuzz-" + std::to_string(::getpid()));
  Folder() { fs::create_directories(path); }
  ~Folder() {
    std::error_code error;
    fs::remove_all(path, error);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const FuzzTarget target = target_named(std::getenv("SIMPLEXSEG_FUZZ_TARGET"));
  static const Folder folder;
  const fs::path path = folder.path / target.file;
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  if (const std::string fault = simplexseg::test::fault_of(target, path); !fault.empty()) {
    std::fprintf(stderr, "fuzz: %s\n", fault.c_str());
    std::abort();
  }
  return 0;
}
