// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "cli/archive.h"
#include "io/files.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Options {
  ArchiveOptions archive;
  std::string study, out, cache;
  std::vector<std::string> series;
  double limit_gb = double(ArchiveCache::kUsualLimit) / 1e9;
  bool json = false;
};

/// A copy beside the target, and then all of it at once.
void copy_series(const fs::path& from, const fs::path& to) {
  const fs::path parent = fs::absolute(to).parent_path();
  std::string partial = (parent / ".simplexseg-XXXXXX").string();
  std::error_code failure;
  fs::create_directories(parent, failure);
  if (!::mkdtemp(partial.data()))
    throw Failure("cannot write " + quoted(to) + ": " + std::strerror(errno) + "; check the folder");
  fs::copy(from, partial, failure);
  if (!failure) fs::permissions(partial, fs::status(parent).permissions(), failure);
  if (!failure) fs::rename(partial, to, failure);
  if (!failure) return;
  const std::string why = failure.message();
  fs::remove_all(partial, failure);
  throw Failure("cannot write " + quoted(to) + ": " + why + "; check the space left on the disk");
}

void get(const Options& options, const Console& console) {
  const std::unique_ptr<Archive> archive = open_archive(server_of(options.archive));
  const ArchiveCache cache(options.cache.empty() ? ArchiveCache::archive_cache_folder() : fs::path(options.cache),
                           static_cast<std::uint64_t>(options.limit_gb * 1e9));
  std::error_code ignored;
  if (!options.out.empty() && fs::exists(options.out, ignored))
    throw Error("cannot write " + quoted(options.out), "it is there already", "name a folder that is not");
  Json json = {{"series", Json::array()}};
  std::vector<std::string> wanted = options.series;
  if (wanted.empty()) {
    with_archive(console, "searching", [&](const ArchiveProgress& progress) {
      for (const ArchiveSeries& series : archive->find_series(options.study, progress)) wanted.push_back(series.uid);
    });
  }
  if (!options.out.empty() && wanted.size() > 1)
    throw Error("--out", "the study has " + std::to_string(wanted.size()) + " series, and a folder is of one",
                "name the series");
  for (const std::string& series : wanted) {
    fs::path folder;
    with_archive(console, "fetching", [&](const ArchiveProgress& progress) {
      folder = archive->fetch(options.study, series, cache, progress);
    });
    if (!options.out.empty()) {
      copy_series(folder, options.out);
      folder = options.out;
    }
    if (!options.json) console.out << folder.string() << std::endl;
    const auto files = std::distance(fs::directory_iterator(folder), fs::directory_iterator());
    json["series"].push_back({{"series", series}, {"folder", folder.string()}, {"files", files}});
  }
  if (options.json) console.out << json.dump(2, ' ', false, Json::error_handler_t::replace) << "\n";
}

}  // namespace

void add_archive_get(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("get", "Fetches series into the cache, and prints their folders");
  const auto options = std::make_shared<Options>();
  sub.add_option("STUDY", options->study, "UID of the study").required();
  sub.add_option("SERIES", options->series, "UIDs of series; without them all of the study").expected(0, 1000);
  sub.add_option("--out", options->out, "Copy the series into this folder, which is made");
  sub.add_option("--cache", options->cache, "Folder of the cache; without it simplexseg/archive in ~/.cache");
  sub.add_option("--cache-limit", options->limit_gb, "Of the cache in GB: series that were used least lately go")
      .within(0.001, 1e6)
      .show_default();
  add_archive_options(sub, options->archive);
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { get(*options, console); }; });
}

}  // namespace simplexseg
