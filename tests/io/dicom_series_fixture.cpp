// SPDX-License-Identifier: Apache-2.0
#include "dicom_series_fixture.h"

#include <cmath>
#include <cstdio>
#include <fstream>

#include "dicom_files.h"
#include "io/volume/volume_io.h"
#include "mesh/iso_surface.h"

namespace simplexseg::test {

std::string DicomSeriesTest::output_and_errors_of(const std::string& command) {
  std::FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (!pipe) return {};
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return ::pclose(pipe) == 0 ? text : "failed: " + text;
}
bool DicomSeriesTest::succeeds(const std::string& command) {
  return !output_and_errors_of(command).starts_with("failed");
}
std::string DicomSeriesTest::in_shell(const std::filesystem::path& path) {
  return std::string(" '").append(path.string()).append("'");
}

void DicomSeriesTest::expect_same_voxels(const Volume& a, const Volume& b) {
  ASSERT_TRUE(a.geometry().same_grid(b.geometry(), 1e-6));
  std::size_t differ = 0, labelled = 0;
  for (int k = 0; k < a.geometry().size[2]; ++k)
    for (int j = 0; j < a.geometry().size[1]; ++j)
      for (int i = 0; i < a.geometry().size[0]; ++i) {
        differ += a.value(i, j, k) != b.value(i, j, k);
        labelled += a.value(i, j, k) != 0;
      }
  EXPECT_EQ(differ, 0u);
  EXPECT_GT(labelled, 100u);
}

void DicomSeriesTest::write_series(const std::string& charset, const std::string& study) {
  std::filesystem::create_directories(folder / "ct");
  for (int k = 0; k < kSlices; ++k) {
    DicomData data;
    if (!charset.empty()) data.text(0x0008, 0x0005, "CS", charset);
    data.text(0x0008, 0x0008, "CS", "ORIGINAL\\PRIMARY\\AXIAL").text(0x0008, 0x0016, "UI", kCt);
    data.text(0x0008, 0x0018, "UI", "1.2.3.4." + std::to_string(k + 1)).text(0x0008, 0x0020, "DA", "20200102");
    data.text(0x0008, 0x0030, "TM", "101112").text(0x0008, 0x0060, "CS", "CT");
    data.text(0x0010, 0x0010, "PN", "M\xfcller^J").text(0x0010, 0x0020, "LO", "patient 7");
    if (!study.empty()) data.text(0x0020, 0x000d, "UI", study);
    data.text(0x0020, 0x000e, "UI", "1.2.3.8")
        .text(0x0020, 0x0010, "SH", "7")
        .text(0x0020, 0x0013, "IS", std::to_string(k + 1));
    const Eigen::Vector3d at = place(k);
    data.numbers(0x0020, 0x0032, {at[0], at[1], at[2]}).numbers(0x0020, 0x0037, {0.8, 0.6, 0, 0, 0, -1});
    data.text(0x0020, 0x0052, "UI", "1.2.3.7");
    describe_pixels(data, kColumns, kRows, 0).numbers(0x0028, 0x0030, {1.25, 1.5});
    data.raw(0x7fe0, 0x0010, "OW", std::string(2 * kColumns * kRows, '\1'));
    std::ofstream(file_of(k), std::ios::binary) << dicom_file(data.bytes, kCt);
  }
}

std::string DicomSeriesTest::images() const {
  std::string all;
  for (int k = 0; k < kSlices; ++k) all += in_shell(file_of(k));
  return all;
}

Volume DicomSeriesTest::image() const { return read_volume(folder / "ct"); }

Scene DicomSeriesTest::scene() const {
  const VolumeGeometry grid = image().geometry();
  const auto mm = [&](double i, double j, double k) { return grid.world_from_index() * Eigen::Vector3d(i, j, k); };
  Scene scene;
  scene.volume_path = (folder / "ct").string();
  const std::pair<const char*, Colour> meshes[] = {{"Left kidney", {230, 160, 60}}, {"a \\ \xc3\xa9 b", {1, 128, 255}}};
  for (const auto& [name, colour] : meshes) {
    MeshItem& item = scene.meshes.emplace_back();
    item.id = static_cast<ItemId>(scene.meshes.size());
    item.label = static_cast<int>(scene.meshes.size());
    item.name = name, item.colour = colour;
  }
  scene.meshes[0].mesh = make_sphere(mm(7, 12, 4), 6.3, 3);
  scene.meshes[1].mesh = ring(grid);
  return scene;
}

SimplexMesh DicomSeriesTest::ring(const VolumeGeometry& grid) {
  std::vector<float> values;
  for (int k = 0; k < kSlices; ++k)
    for (int j = 0; j < kRows; ++j)
      for (int i = 0; i < kColumns; ++i)
        values.push_back(static_cast<float>(2.4 - std::hypot(std::hypot(i - 21.0, j - 14.0) - 5.2, k - 5.1)));
  return dual_of(iso_surface(values, grid.size, 0, grid.world_from_index()));
}

}  // namespace simplexseg::test
