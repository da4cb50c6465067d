// SPDX-License-Identifier: Apache-2.0
// A CT series and a scene of two meshes, from which DICOM objects are written.
#pragma once
#include <filesystem>
#include <string>

#include "session/scene.h"
#include "test_files.h"

namespace simplexseg::test {

class DicomSeriesTest : public FolderTest {
 protected:
  static constexpr int kColumns = 30, kRows = 26, kSlices = 9;
  static constexpr const char* kCt = "1.2.840.10008.5.1.4.1.1.2";

  /// Writes an oblique CT series; the file names are not in the order of the positions.
  void write_series(const std::string& charset = "ISO_IR 100", const std::string& study = "1.2.3.9");
  static Eigen::Vector3d place(int k) { return Eigen::Vector3d(10, -20, 30) + 2.5 * k * Eigen::Vector3d(-0.6, 0.8, 0); }
  std::filesystem::path file_of(int k) const { return folder / "ct" / std::to_string(k * 7 % kSlices); }
  /// Returns the paths of all images as arguments of a shell.
  std::string images() const;

  Volume image() const;
  /// Returns two meshes: a sphere, and a torus around the slice normal, whose sections have holes.
  Scene scene() const;

  /// Returns standard output and standard error of a command, with the prefix "failed: " when it fails.
  static std::string output_and_errors_of(const std::string& command);
  static bool succeeds(const std::string& command);
  /// Returns the path as an argument of a shell, with a leading space.
  static std::string in_shell(const std::filesystem::path& path);
  /// Requires equal grids, equal values, and labelled voxels in a.
  static void expect_same_voxels(const Volume& a, const Volume& b);

 private:
  static SimplexMesh ring(const VolumeGeometry& grid);
};

}  // namespace simplexseg::test
