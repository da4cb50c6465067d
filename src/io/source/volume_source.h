// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"
#include "io/source/volume_info.h"

namespace simplexseg {

/// Opened volume: its header is read, its voxels are not. Each family of formats has a function that returns one.
struct VolumeSource {
  VolumeInfo info;
  std::size_t extra_bytes = 0;               ///< memory for reading in addition to the volume
  std::vector<DicomSlice> dicom;             ///< origin of each slice, in order; empty unless it is a DICOM image
  std::function<Volume()> read;              ///< reads the voxels; requires one component and a selected volume
  std::shared_ptr<const void> keep_alive{};  ///< owner of temporary files that `dicom` refers to
};

/// Factors that convert RAS positions (NIfTI, MINC) to LPS.
inline const Eigen::Vector3d kLpsFromRas(-1, -1, 1);

/// Selects number `volume` (from 1) of info.frames volumes: sets info.frame and, for 4D, adds a warning. `name`
/// describes the volume ("trigger time 40") or is empty. Throws Error starting with `context` when there are fewer
/// volumes.
void select_volume(VolumeInfo& info, int volume, const std::string& context, const std::string& name = "");

/// Adds a warning when the axes are not at right angles.
void warn_if_sheared(VolumeInfo& info);

/// Throws the Error for a file with fewer bytes than its header requires.
[[noreturn]] void throw_truncated(const std::filesystem::path& path, double bytes_required, double bytes_present);

/// Copies 64-bit integers to 32-bit integers. Throws Error when a value does not fit.
template <class From, class To>
void narrow(const From* from, std::size_t count, To* to, const std::string& name);

}  // namespace simplexseg

#include <limits>

#include "core/error.h"

template <class From, class To>
void simplexseg::narrow(const From* from, std::size_t count, To* to, const std::string& name) {
  for (std::size_t i = 0; i < count; ++i) {
    if (from[i] < From(std::numeric_limits<To>::min()) || from[i] > From(std::numeric_limits<To>::max())) {
      throw Error("cannot read " + name,
                  "its 64-bit voxel value " + std::to_string(from[i]) + " does not fit into 32 bits",
                  "save it as float or with 32-bit integers");
    }
    to[i] = static_cast<To>(from[i]);
  }
}
