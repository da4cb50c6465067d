// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <nlohmann/json.hpp>
#include <ostream>

#include "app/progress.h"
#include "cli/commands.h"
#include "core/number_text.h"
#include "io/platform/files.h"
#include "io/source/volume_source.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

struct InfoOptions {
  std::string path;
  int volume = 1;
  bool json = false;
};

nlohmann::ordered_json json_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

std::string text_of(const Eigen::Vector3d& v) {
  return general_text(v.x() + 0.0, 6) + ", " + general_text(v.y() + 0.0, 6) + ", " + general_text(v.z() + 0.0, 6);
}

void info(const InfoOptions& options, const Console& console) {
  const VolumeSource source = open_volume(options.path, options.volume);
  const VolumeInfo& info = source.info;
  std::vector<std::string> warnings = info.warnings;
  Volume::Range range{0, 0};
  const bool readable = info.components == 1 && (info.frames == 1 || info.frame > 0);
  if (readable) {  // also reads the voxels, which detects truncated files
    const Progress progress(console, "reading");
    const LoadedVolume loaded = load_volume(source, options.path);
    range = loaded.volume.range();
    warnings = loaded.warnings;
  }
  const VolumeGeometry& geometry = info.geometry;
  if (options.json) {
    nlohmann::ordered_json json = {
        {"path", options.path},
        {"format", info.format},
        {"size", geometry.size},
        {"spacing_mm", json_of(geometry.spacing_mm)},
        {"origin_mm", json_of(geometry.origin_mm)},
        {"direction",
         {json_of(geometry.direction.row(0)), json_of(geometry.direction.row(1)), json_of(geometry.direction.row(2))}},
        {"voxel_type", to_string(info.type)},
        {"components", info.components},
        {"frames", info.frames},
        {"files", info.file_count}};
    if (info.frame > 0) json["frame"] = info.frame;
    for (const SegmentName& s : info.segments) json["segments"].push_back({{"value", s.value}, {"name", s.name}});
    if (readable) json["range"] = {range.min, range.max};
    json["warnings"] = warnings;
    console.out << json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << "\n";
    require_one_value(options.path, info);
    return;
  }
  console.out << "file        " << options.path << "\n"
              << "format      " << info.format
              << (info.file_count > 1 ? ", " + std::to_string(info.file_count) + " files" : "") << "\n"
              << "size        " << geometry.size[0] << " x " << geometry.size[1] << " x " << geometry.size[2]
              << " voxels";
  if (info.frames > 1) console.out << ", " << info.frames << " volumes";
  if (info.components > 1) console.out << ", " << info.components << " values per voxel";
  console.out << "\nspacing     " << text_of(geometry.spacing_mm) << " mm\n"
              << "origin      " << text_of(geometry.origin_mm) << " mm (LPS, centre of the first voxel)\n"
              << "direction   i: " << text_of(geometry.direction.col(0)) << "\n"
              << "            j: " << text_of(geometry.direction.col(1)) << "\n"
              << "            k: " << text_of(geometry.direction.col(2)) << "\n"
              << "voxels      " << to_string(info.type) << ", "
              << format_bytes(static_cast<double>(geometry.voxel_count() * bytes_per_voxel(info.type))) << "\n";
  if (readable) console.out << "range       " << range.min << " to " << range.max << "\n";
  for (const SegmentName& s : info.segments) console.out << "segment     " << s.value << " " << s.name << "\n";
  for (const std::string& warning : warnings) console.out << "warning     " << one_line(warning, 1000) << "\n";
  require_one_value(options.path, info);  // throws, after the description, if the volume cannot be loaded
}

}  // namespace

void add_info(const Subcommand& app, Action& action) {
  const Subcommand sub =
      app.add_subcommand("info", "Prints geometry, voxel type, range of values and warnings of a volume");
  const auto options = std::make_shared<InfoOptions>();
  sub.add_option("PATH", options->path, "Volume file, or folder of a DICOM series").required();
  sub.add_option("--volume", options->volume, "Number of the volume in a 4D file or series, counted from 1")
      .within(1, kMaxVolumes);
  sub.add_flag("--json", options->json, "Print JSON");
  sub.callback([options, &action] { action = [options](const Console& console) { info(*options, console); }; });
}

}  // namespace simplexseg
