// SPDX-License-Identifier: Apache-2.0
// Measurements of a scene in the table of `measure` and in reports.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "app/table.h"
#include "cli_fixture.h"

namespace simplexseg {
namespace {

class Measure : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    make_scene();
    nlohmann::json scene = scene_json();
    scene["measurements"] = {{{"name", "width, \"a\""}, {"kind", "ruler"}, {"points_mm", {{0, 0, 0}, {3, 4, 0}}}},
                             {{"name", "disc"}, {"kind", "ellipse"}, {"points_mm", {{0, 0, 0}, {8, 0, 0}, {0, 6, 0}}}}};
    write_scene("scene.json", scene);
  }
};

TEST_F(Measure, WritesATableOfMeasurementsAndMeshes) {
  const Outcome printed = succeed({"measure", path("scene.json")});
  EXPECT_EQ(printed.out.find("name,kind,length_mm,"), 0u) << printed.out;
  EXPECT_NE(printed.out.find("\n\"width, \"\"a\"\"\",ruler,5,"), std::string::npos) << printed.out;
  EXPECT_NE(printed.out.find("\ndisc,ellipse,,,150.7964,"), std::string::npos) << printed.out;
  EXPECT_NE(printed.out.find("\nball,segmentation,"), std::string::npos) << printed.out;
  EXPECT_EQ(std::count(printed.out.begin(), printed.out.end(), '\n'), 4);
  const Outcome written = succeed({"measure", path("scene.json"), path("table.csv")});
  EXPECT_EQ(written.out, "");
  EXPECT_EQ(text_of("table.csv"), printed.out);
}

/// Output of a shell command; "" if it fails.
std::string output_of_command(const std::string& command) {
  std::FILE* pipe = ::popen((command + " 2>/dev/null").c_str(), "r");
  if (!pipe) return {};
  std::string text;
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) text += static_cast<char>(c);
  return ::pclose(pipe) == 0 ? text : "";
}

TEST_F(Measure, WritesAReportOfTheCaseWithChecksumAndPrompts) {
  succeed({"measure", path("scene.json"), path("report.pdf"), path("table.csv")});
  EXPECT_EQ(text_of("report.pdf").substr(0, 5), "%PDF-");
  const std::string text = output_of_command("pdftotext -layout '" + path("report.pdf") + "' -");
  if (text.empty()) GTEST_SKIP() << "pdftotext of poppler-utils is absent";
  const std::string checksum = output_of_command("sha256sum '" + path("image.nii.gz") + "'").substr(0, 64);
  ASSERT_EQ(checksum.size(), 64u);
  for (const std::string& part : {std::string("Not for diagnostic use."), std::string("not for diagnostic use"),
                                  checksum, std::string("Program"), std::string("ball"), std::string("width, \"a\""),
                                  std::string("5.00 mm"), std::string("seed"), std::string("image.nii.gz")})
    EXPECT_NE(text.find(part), std::string::npos) << part << " in\n" << text;
  // Volume of the object as in the table, in ml.
  const std::string table = text_of("table.csv");
  const std::string row = table.substr(table.find("\nball,") + 1);
  std::istringstream fields(row);
  std::string field;
  for (int column = 0; column < 11; ++column) std::getline(fields, field, ',');
  EXPECT_NE(text.find(readable(std::stod(field) / 1000, 2)), std::string::npos) << field << " mm3 in\n" << text;
  EXPECT_EQ(text.find("Patient"), std::string::npos);
}

TEST_F(Measure, RefusesOutputsThatCannotBeWritten) {
  for (const std::string& output : {path("scene.json"), path("missing/table.csv")}) {
    const Outcome outcome = call({"measure", path("scene.json"), output});
    EXPECT_EQ(outcome.status, 2) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

TEST_F(Measure, AReportHasMeasurementsAndAxes) {
  const Outcome run =
      succeed({"run", path("scene.json"), "--steps", "200", "--report", path("report.json"), "--save", path("b.json")});
  const nlohmann::json report = json_of("report.json");
  ASSERT_EQ(report["measurements"].size(), 2u);
  EXPECT_EQ(report["measurements"][0]["kind"], "ruler");
  EXPECT_EQ(report["measurements"][0]["length_mm"], 5);
  EXPECT_GT(report["measurements"][1]["voxels"], 20);
  EXPECT_GT(report["measurements"][1]["mean"], 0);
  const nlohmann::json& mesh = report["meshes"][0];
  EXPECT_GE(mesh["long_axis_mm"].get<double>(), mesh["short_axis_mm"].get<double>());
  // The object is a ball with a radius of 0.3 of the width.
  EXPECT_NEAR(mesh["long_axis_mm"].get<double>(), 2 * 0.3 * 48, 2.5);
  EXPECT_NEAR(mesh["axes_slice"].get<double>(), 12.5, 2);
  EXPECT_NE(run.out.find("long mm"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("5.00 mm"), std::string::npos) << run.out;
  // The saved scene has the same measurements.
  EXPECT_EQ(json_of("b.json")["measurements"], json_of("scene.json")["measurements"]);
}

}  // namespace
}  // namespace simplexseg
