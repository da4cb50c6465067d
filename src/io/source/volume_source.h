// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/source/dicom_slice.h"
#include "io/source/volume_info.h"

namespace simplexseg {

/// Opened volume: the header has been read, the voxels have not. Each file format has a function that returns a
/// VolumeSource.
struct VolumeSource {
  VolumeInfo info;
  std::size_t extra_bytes = 0;    ///< memory for reading in addition to the volume, bytes
  std::vector<DicomSlice> dicom;  ///< header data of each slice k; empty unless it is a DICOM image
  std::function<Volume()> read;   ///< reads the voxels; requires one component and a selected volume
  /// Reads the voxels of the segment with this number; all others are 0. Empty if segments cannot share voxels.
  std::function<Volume(int)> read_segment{};
  /// Warnings about voxels, which read() replaces, one line each; null if the format has none.
  std::shared_ptr<std::vector<std::string>> voxel_warnings{};
  std::shared_ptr<const void> keep_alive{};  ///< owner of temporary files that `dicom` refers to
};

/// Factors that convert RAS positions (NIfTI, MINC) to LPS.
inline const Eigen::Vector3d kLpsFromRas(-1, -1, 1);

/// Selects volume number `volume` (from 1) of info.frames volumes. For 4D, sets info.frame and adds a warning that
/// contains `name`, a description of the volume ("trigger time 40") or an empty text. Throws Error whose message starts
/// with `context` when the volume does not exist.
void select_volume(VolumeInfo& info, int volume, const std::string& context, const std::string& name = "");

/// Deviation of the axes of a grid from right angles, degrees; nullopt when it is at most the rounding of headers.
std::optional<double> shear_degrees(const VolumeGeometry& geometry);
/// Adds a warning when the axes of the grid are not at right angles.
void warn_if_sheared(VolumeInfo& info);

/// Throws the Error for a file that contains fewer bytes than its header requires. `bytes_present` is an upper bound
/// for compressed data.
[[noreturn]] void throw_truncated(const std::filesystem::path& path, double bytes_required, double bytes_present);

/// Converts `count` 64-bit integers to 32-bit integers. `name` is the file name in messages. Throws Error when a value
/// does not fit.
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
