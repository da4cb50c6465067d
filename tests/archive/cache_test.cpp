// SPDX-License-Identifier: Apache-2.0
#include "archive/cache.h"

#include <thread>

#include "io/test_files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using test::error_of;

class Cache : public test::FolderTest {
 protected:
  Cache() : cache(folder / "cache", 1000) { server.name = "a", server.url = "https://archive.example/x"; }

  /// Adds a series of two instances with this total size.
  fs::path put(const std::string& series, std::size_t bytes) {
    IncomingSeries incoming(cache, cache.folder_of(server, series));
    for (const char* name : {"1.1.dcm", "1.2.dcm"})
      std::ofstream(incoming.folder() / name) << std::string(bytes / 2, 'x');
    return incoming.commit();
  }
  bool has(const std::string& series) { return cache.find(server, series, {"1.1", "1.2"}).has_value(); }
  /// Number of temporary entries in the cache.
  int leftovers() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator(cache.root()))
      count += entry.path().filename().string().find('-') != std::string::npos;
    return count;
  }

  ArchiveCache cache;
  ArchiveServer server;
};

TEST_F(Cache, FindsCompleteSeriesOfTheServer) {
  EXPECT_FALSE(has("1.5"));
  const fs::path kept = put("1.5", 100);
  EXPECT_EQ(cache.find(server, "1.5", {"1.1", "1.2"}), kept);
  EXPECT_FALSE(cache.find(server, "1.5", {"1.1"}));
  EXPECT_FALSE(cache.find(server, "1.5", {"1.1", "1.2", "1.3"}));
  ArchiveServer other = server;
  other.url = "https://other.example/x";
  EXPECT_FALSE(cache.find(other, "1.5", {"1.1", "1.2"}));
  EXPECT_EQ(cache.size(), 100u);
  EXPECT_EQ(fs::status(cache.root()).permissions(), fs::perms::owner_all);
  EXPECT_FALSE(error_of([&] { cache.folder_of(server, "../x"); }).empty());
  put("1.5", 60);  // fetched again
  EXPECT_EQ(cache.size(), 60u);
  EXPECT_EQ(leftovers(), 0);
  cache.clear();
  EXPECT_FALSE(has("1.5"));
}

TEST_F(Cache, RemovesLeastRecentlyUsedSeries) {
  using namespace std::chrono_literals;
  for (const char* series : {"1.1", "1.2", "1.3"}) {
    put(series, 300);
    std::this_thread::sleep_for(20ms);
  }
  cache.make_room(100);
  EXPECT_EQ(cache.size(), 900u);
  EXPECT_TRUE(has("1.1"));  // counts as a use
  std::this_thread::sleep_for(20ms);
  cache.make_room(101);
  EXPECT_FALSE(has("1.2"));
  EXPECT_TRUE(has("1.1") && has("1.3"));
  cache.make_room(900, cache.folder_of(server, "1.1"));
  EXPECT_TRUE(has("1.1"));
  EXPECT_EQ(leftovers(), 0);
}

TEST_F(Cache, RemovesAbandonedFoldersAndKeepsLockedOnes) {
  fs::path begun;
  {
    IncomingSeries incoming(cache, cache.folder_of(server, "1.7"));
    begun = incoming.folder();
    std::ofstream(begun / "1.1.dcm") << "x";
    const IncomingSeries other(cache, cache.folder_of(server, "1.8"));
    EXPECT_TRUE(fs::exists(begun / "1.1.dcm"));
  }
  EXPECT_FALSE(fs::exists(begun));
  fs::create_directories(cache.root() / "incoming-killed");  // not locked
  std::ofstream(cache.root() / "incoming-killed" / "1.1.dcm") << "x";
  put("1.9", 10);
  EXPECT_EQ(leftovers(), 0);
  EXPECT_EQ(cache.size(), 10u);
}

TEST_F(Cache, ReportsAFolderThatCannotBeCreated) {
  EXPECT_NE(error_of([&] { ArchiveCache(write("file", "x") / "cache"); }).find("cannot store series"),
            std::string::npos);
}

}  // namespace
}  // namespace simplexseg
