// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "cli/archive.h"
#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {
namespace {

struct ArchiveSendOptions {
  ArchiveOptions archive;
  std::vector<std::string> files;
  bool json = false;
};

void send(const ArchiveSendOptions& options, const Console& console) {
  const std::unique_ptr<Archive> archive = open_archive(server_of(options.archive));
  const std::vector<std::filesystem::path> files(options.files.begin(), options.files.end());
  ArchiveSent sent;
  with_archive(console, "sending", [&](const ArchiveProgress& progress) { sent = archive->send(files, progress); });
  if (options.json) {
    const nlohmann::ordered_json json = {{"stored", sent.stored}, {"warnings", sent.warnings}};
    console.out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    return;
  }
  for (const std::string& warning : sent.warnings) console.err << "warning: " << one_line(warning) << "\n";
  console.out << "sent " << counted(sent.stored, "file") << "\n";
}

}  // namespace

void add_archive_send(const Subcommand& app, Action& action) {
  const Subcommand sub = app.add_subcommand("send", "Sends DICOM files to an archive");
  const auto options = std::make_shared<ArchiveSendOptions>();
  sub.add_option("FILES", options->files, "DICOM files: images, segmentations, structure sets, secondary captures")
      .required();
  add_archive_options(sub, options->archive);
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { send(*options, console); }; });
}

}  // namespace simplexseg
