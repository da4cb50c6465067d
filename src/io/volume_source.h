// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "io/dicom_slice.h"
#include "io/volume_io.h"

namespace simplexseg {

/// An opened volume: described, its voxels not yet read. One function for each family of formats makes one.
struct VolumeSource {
  VolumeInfo info;
  std::size_t extra_bytes = 0;         ///< memory the reading takes besides the volume itself
  std::vector<DicomSlice> dicom;       ///< of a DICOM image: where each of its slices comes from, in their order
  std::function<Volume()> read;        ///< reads the voxels; called only for one component and one frame
  std::shared_ptr<const void> kept{};  ///< what has to live as long as the files of `dicom` are read
};

/// Opens a file or a folder of whatever format, as read_volume_info() says.
VolumeSource open_volume(const std::filesystem::path& path, int volume = 1, const std::string& series = {});

/// NIfTI and MINC give positions in RAS; this, component by component, turns them to LPS.
inline const Eigen::Vector3d kLpsFromRas(-1, -1, 1);

/// Takes number `volume`, from 1, of info.frames: sets info.frame, and says so where there are several; `name` tells
/// the volume apart ("trigger time 40") where the file does. Throws Error, which begins with `what`, when there are
/// fewer.
void take_volume(VolumeInfo& info, int volume, const std::string& what, const std::string& name = "");

/// Adds a warning when the axes are not at right angles.
void warn_if_sheared(VolumeInfo& info);

/// Throws the Error for a file that ends before its header says.
[[noreturn]] void throw_truncated(const std::filesystem::path& path, double bytes_wanted, double bytes_there);

/// Copies 64-bit integers into a volume of 32-bit ones. Throws Error when one does not fit.
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
