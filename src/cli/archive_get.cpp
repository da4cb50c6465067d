// SPDX-License-Identifier: Apache-2.0
#include <stdlib.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "cli/archive.h"
#include "core/system_error.h"
#include "io/platform/files.h"
#include "io/platform/output_checks.h"

namespace simplexseg {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct ArchiveGetOptions {
  ArchiveOptions archive;
  std::string study, out, cache;
  std::vector<std::string> series;
  double limit_gb = double(ArchiveCache::kDefaultLimit) / 1e9;
  bool json = false;
};

/// Copies a folder. The copy is made next to the target and renamed when it is complete.
void copy_series(const fs::path& from, const fs::path& to) {
  const fs::path parent = fs::absolute(to).parent_path();
  std::string partial = (parent / ".simplexseg-XXXXXX").string();
  std::error_code failure;
  fs::create_directories(parent, failure);
  if (!::mkdtemp(partial.data()))
    throw Failure("cannot write " + quoted(to) + ": " + system_error_text(errno) + "; choose another folder");
  fs::copy(from, partial, failure);
  if (!failure) fs::permissions(partial, fs::status(parent).permissions(), failure);
  if (!failure) fs::rename(partial, to, failure);
  if (!failure) return;
  const std::string why = system_error_text(failure);
  fs::remove_all(partial, failure);
  throw Failure("cannot write " + quoted(to) + ": " + why + "; choose another folder");
}

void check_output(const ArchiveGetOptions& options) {
  if (options.out.empty()) return;
  std::error_code ignored;
  if (fs::exists(options.out, ignored))
    throw Error("cannot write " + quoted(options.out), "the folder exists already", "choose a new folder");
  require_writable_folder(options.out);
  if (options.series.size() > 1)
    throw Error("--out", std::to_string(options.series.size()) + " series are named, but --out accepts only one",
                "name one series");
}

void get(const ArchiveGetOptions& options, const Console& console) {
  check_output(options);
  const std::unique_ptr<Archive> archive = open_archive(server_of(options.archive));
  const ArchiveCache cache(options.cache.empty() ? ArchiveCache::archive_cache_folder() : fs::path(options.cache),
                           static_cast<std::uint64_t>(options.limit_gb * 1e9));
  Json json = {{"series", Json::array()}};
  std::vector<std::string> series_uids = options.series;
  if (series_uids.empty()) {
    with_archive(console, "searching", [&](const ArchiveProgress& progress) {
      for (const ArchiveSeries& series : archive->find_series(options.study, progress))
        series_uids.push_back(series.uid);
    });
  }
  if (!options.out.empty() && series_uids.size() > 1)
    throw Error("--out", "the study has " + std::to_string(series_uids.size()) + " series, but --out accepts only one",
                "name one series");
  for (const std::string& series : series_uids) {
    fs::path folder;
    with_archive(console, "downloading", [&](const ArchiveProgress& progress) {
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
  const Subcommand sub = app.add_subcommand("get", "Downloads series into the cache and prints their folders");
  const auto options = std::make_shared<ArchiveGetOptions>();
  sub.add_option("STUDY", options->study, "UID of the study").required();
  sub.add_option("SERIES", options->series, "UIDs of series; default: all series of the study").expected(0, 1000);
  sub.add_option("--out", options->out, "New folder for a copy of the series").not_empty();
  sub.add_option("--cache", options->cache, "Folder of the cache; default: simplexseg/archive in ~/.cache");
  sub.add_option("--cache-limit", options->limit_gb,
                 "Size limit of the cache, GB; the least recently used series are deleted first")
      .within(0.001, 1e6)
      .show_default();
  add_archive_options(sub, options->archive);
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { get(*options, console); }; });
}

}  // namespace simplexseg
