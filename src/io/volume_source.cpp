// SPDX-License-Identifier: Apache-2.0
#include "io/volume_source.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "io/files.h"

namespace simplexseg {

namespace fs = std::filesystem;

void take_volume(VolumeInfo& info, int volume, const std::string& what, const std::string& name) {
  if (volume < 1 || volume > info.frames) {
    throw Error(what,
                info.frames == 1 ? "it holds one volume, number " + std::to_string(volume) + " is asked for"
                                 : "it holds " + std::to_string(info.frames) + " volumes, number " +
                                       std::to_string(volume) + " is asked for",
                info.frames == 1 ? "ask for the first" : "name one from 1 to " + std::to_string(info.frames));
  }
  if (info.frames == 1) return;
  info.frame = volume;
  info.warnings.push_back("4D: it holds " + std::to_string(info.frames) + " volumes; number " + std::to_string(volume) +
                          " is taken" + (name.empty() ? "" : " (" + name + ")"));
}

void warn_if_sheared(VolumeInfo& info) {
  const Eigen::Matrix3d& d = info.geometry.direction;
  const double most = (d.transpose() * d - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (most < 1e-3) return;
  char text[120];
  std::snprintf(text, sizeof text,
                "the axes are %.3g degrees off right angles (sheared grid); they are kept as they are",
                std::asin(std::min(most, 1.0)) * 180 / M_PI);
  info.warnings.push_back(text);
}

void throw_truncated(const fs::path& path, double bytes_wanted, double bytes_there) {
  throw Error(
      "cannot read " + quoted(path),
      "truncated: its header promises " + in_words(bytes_wanted) + ", the file holds at most " + in_words(bytes_there),
      "copy or export it again");
}

}  // namespace simplexseg
