// SPDX-License-Identifier: Apache-2.0
// Files are read and written with a decimal point under every locale; tests/locale/run repeats the tests of this
// program under locales with a decimal comma.
#include "dicom_slices.h"
#include "io/mesh/mesh_io.h"
#include "io/picture/plot_axis.h"
#include "io/platform/files.h"
#include "io/volume/volume_io.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using LocaleTest = test::FolderTest;

TEST_F(LocaleTest, TheFirstEchoIsTheFirstVolume) {
  test::write_echoes(folder / "echoes");
  EXPECT_EQ(load_volume(folder / "echoes", 1).volume.value(0, 0, 0), 46);
  EXPECT_EQ(load_volume(folder / "echoes", 2).volume.value(0, 0, 0), 123);
}

TEST_F(LocaleTest, TheReportedEchoes) {
  const auto echo = test::data_folder() / "reports" / "echo";
  REQUIRE_DATA(echo);
  const auto warning = [&](int volume) { return read_volume_info(echo, volume).warnings.at(0); };
  EXPECT_EQ(warning(1), "4D: volume 1 of 2 is loaded (echo time 4.6)");
  EXPECT_EQ(warning(2), "4D: volume 2 of 2 is loaded (echo time 12.3)");
}

TEST_F(LocaleTest, SizesAndAxesHaveADecimalPoint) {
  EXPECT_EQ(format_bytes(999), "999 bytes");
  EXPECT_EQ(format_bytes(1500), "1.5 kB");
  const PlotAxis axis = make_axis({0.0, 0.5}, false, 5);
  std::string labels;
  for (const PlotAxis::Tick& tick : axis.ticks) labels += tick.label + ' ';
  EXPECT_NE(labels.find("0.2"), std::string::npos) << labels;
  EXPECT_EQ(labels.find(','), std::string::npos) << labels;
}

TEST_F(LocaleTest, NumbersOfMeshesAreWholeOrRefused) {
  const std::string obj = "v 0 0 0\nv 1.5 0 0\nv 0 1.5 0\nv 0 0 1.5\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
  EXPECT_NO_THROW(read_mesh(write("point.obj", obj)));
  std::string comma = obj;
  comma.replace(comma.find("1.5"), 3, "1,5");
  EXPECT_HAS(test::error_of([&] { read_mesh(write("comma.obj", comma)); }), "'1,5' is not a number");

  const auto ply = [](const std::string& x, const std::string& corner) {
    return "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
           "element face 4\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n" +
           x + " 0 0\n0 1.5 0\n0 0 1.5\n3 0 2 1\n3 0 1 3\n3 0 3 " + corner + "\n3 1 2 3\n";
  };
  EXPECT_NO_THROW(read_mesh(write("point.ply", ply("1.5", "2"))));
  EXPECT_NO_THROW(read_mesh(write("plus.ply", ply("+1.5e0", "2.0"))));
  EXPECT_HAS(test::error_of([&] { read_mesh(write("comma.ply", ply("1,5", "2"))); }), "'1,5' is not a number");
  EXPECT_HAS(test::error_of([&] { read_mesh(write("points.ply", ply("1.5.5", "2"))); }), "'1.5.5' is not a number");
  EXPECT_HAS(test::error_of([&] { read_mesh(write("part.ply", ply("1.5", "2.5"))); }), "'2.5' is not a whole number");
}

}  // namespace
}  // namespace simplexseg
