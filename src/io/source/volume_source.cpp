// SPDX-License-Identifier: Apache-2.0
#include "io/source/volume_source.h"

#include <algorithm>
#include <cmath>

#include "core/number_text.h"
#include "io/platform/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

void select_volume(VolumeInfo& info, int volume, const std::string& context, const std::string& name) {
  if (volume < 1 || volume > info.frames) {
    throw Error(context,
                (info.frames == 1 ? std::string("it contains one volume")
                                  : "it contains " + std::to_string(info.frames) + " volumes") +
                    ", volume " + std::to_string(volume) + " does not exist",
                info.frames == 1 ? "choose volume 1" : "choose a volume from 1 to " + std::to_string(info.frames));
  }
  if (info.frames == 1) return;
  info.frame = volume;
  info.warnings.push_back("4D: volume " + std::to_string(volume) + " of " + std::to_string(info.frames) + " is loaded" +
                          (name.empty() ? "" : " (" + name + ")"));
}

std::optional<double> shear_degrees(const VolumeGeometry& geometry) {
  const Eigen::Matrix3d& d = geometry.direction;
  const double max_deviation = (d.transpose() * d - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (max_deviation < 1e-3) return std::nullopt;
  return std::asin(std::min(max_deviation, 1.0)) * 180 / M_PI;
}

void warn_if_sheared(VolumeInfo& info) {
  if (const auto degrees = shear_degrees(info.geometry)) {
    info.warnings.push_back("the axes deviate by " + general_text(*degrees, 3) +
                            " degrees from right angles; the volume is loaded as a sheared grid");
  }
}

void throw_truncated(const fs::path& path, double bytes_required, double bytes_present) {
  throw Error("cannot read " + quoted(path),
              "truncated: its header requires " + format_bytes(bytes_required) + ", the file contains at most " +
                  format_bytes(bytes_present),
              "copy or export it again");
}

void require_one_value(const fs::path& path, const VolumeInfo& info) {
  if (info.components > 1) {
    throw Error("cannot read " + quoted(path),
                "it has " + std::to_string(info.components) + " values per voxel (colours, vectors or time points)",
                "extract one of them into a separate file");
  }
  if (info.frames > 1 && info.frame == 0) {
    throw Error("cannot read " + quoted(path),
                "it is 4D and its " + std::to_string(info.frames) + " volumes are interleaved within slices",
                "extract one of them into a separate file");
  }
}

}  // namespace simplexseg
