// SPDX-License-Identifier: Apache-2.0
// Subcommand follow: scene, tables and curve, files that can be read again, and refused options.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <string>

#include "cli_fixture.h"
#include "core/error.h"
#include "io/dicom/dicom_volumes.h"
#include "io/platform/worker_program.h"
#include "io/scene/scene_io.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kCentre(40, 38, 42), kShift(6, -4, 2);
constexpr double kRadius = 14;

/// Bright ball over a background with two dimmer ones, moved by `shift`, mm.
Volume image_of(const Eigen::Vector3d& shift, double radius) {
  Volume volume(VolumeGeometry{.size = {42, 42, 42}, .spacing_mm = {2, 2, 2}}, VoxelType::Int16);
  for (int k = 0; k < 42; ++k)
    for (int j = 0; j < 42; ++j)
      for (int i = 0; i < 42; ++i) {
        const Eigen::Vector3d at = Eigen::Vector3d(2 * i, 2 * j, 2 * k) - shift;
        const auto ball = [&](const Eigen::Vector3d& centre, double r) {
          return 1 / (1 + std::exp(2 * ((at - centre).norm() - r)));
        };
        const double value = 400 * ball(kCentre, radius) + 150 * ball({64, 60, 60}, 9) + 200 * ball({20, 62, 24}, 7);
        volume.voxels<std::int16_t>()[volume.offset(i, j, k)] =
            static_cast<std::int16_t>(value + (7 * i + 13 * j + 29 * k) % 17);
      }
  return volume;
}

class FollowCommand : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    write_volume(path("first.nii.gz"), image_of(Eigen::Vector3d::Zero(), kRadius));
    write_volume(path("next.nii.gz"), image_of(kShift, kRadius * 1.1));
    write_transform(path("shift.tfm"), Transform(Eigen::Affine3d(Eigen::Translation3d(kShift))));
    make_first("first.nii.gz");
  }
  void make_first(const std::string& image) const {
    const nlohmann::json scene = {
        {"simplexseg_scene", 1},
        {"volume", path(image)},
        {"meshes", {{{"name", "lesion"}, {"sphere", {{"centre_mm", {40, 38, 42}}, {"radius_mm", 8}}}}}},
        {"points",
         {{{"mesh", "lesion"}, {"kind", "outside"}, {"position_mm", {64, 38, 42}}, {"radius_mm", 3}},
          {{"mesh", "lesion"}, {"kind", "inside"}, {"position_mm", {46, 38, 42}}, {"radius_mm", 3}}}}};
    write_scene("marks.json", scene);
    succeed({"run", path("marks.json"), "--until-settled", "--save", path("first.json")});
  }
  std::string refusal(const Arguments& arguments, int status = 2) const {
    const Outcome outcome = call(arguments);
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    return outcome.err;
  }
};

TEST_F(FollowCommand, CarriesOverByATransformAndComparesTheStudies) {
  const Outcome result = succeed({"follow", path("first.json"), path("next.nii.gz"), path("next.json"), "--transform",
                                  path("shift.tfm"), "--table", path("table.csv"), "--report", path("report.json")});
  EXPECT_NE(result.out.find("lesion"), std::string::npos);
  const nlohmann::json report = json_of("report.json"), object = report["objects"][0];
  const double growth = std::pow(1.1, 3);
  EXPECT_NEAR(object["now"]["volume_ml"].get<double>() / object["earlier"]["volume_ml"].get<double>(), growth, 0.08);
  EXPECT_NEAR(object["unregistered_shift_mm"], kShift.norm(), 0.7);
  EXPECT_LT(object["shift_mm"].get<double>(), 0.7);
  EXPECT_EQ(report["kept_marks"], 2) << report["dropped"];
  EXPECT_EQ(text_of("table.csv").substr(0, 24), "name,locked,earlier_ml,n");

  const Scene scene = read_scene(path("next.json")).scene;
  ASSERT_EQ(scene.meshes.size(), 1u);
  ASSERT_TRUE(scene.meshes[0].start);
  EXPECT_EQ(scene.meshes[0].start->error_mm, 3);
  EXPECT_NEAR(scene.meshes[0].start->earlier.volume_ml, object["earlier"]["volume_ml"].get<double>(), 1e-9);
  EXPECT_EQ(scene.points.size(), 2u);
  // The scene is complete: it runs from its start again.
  succeed({"run", path("next.json"), "--steps", "20", "--save", path("again.json")});
  EXPECT_EQ(read_scene(path("again.json")).scene.meshes[0].start->error_mm, 3);
}

TEST_F(FollowCommand, RegistersTheStudies) {
  try {
    path_of_program(kRegisterProgram);
  } catch (const Error&) {
    GTEST_SKIP() << "built without ITK";
  }
  succeed({"follow", path("first.json"), path("next.nii.gz"), path("next.json"), "--save-transform", path("out.tfm"),
           "--report", path("report.json")});
  const Transform found = read_transform(path("out.tfm"));
  EXPECT_LT((found(kCentre) - kCentre - kShift).norm(), 1);
  EXPECT_LT(json_of("report.json")["objects"][0]["shift_mm"].get<double>(), 1.2);
  EXPECT_LT(json_of("report.json")["registration"]["metric_after"],
            json_of("report.json")["registration"]["metric_before"]);
}

TEST_F(FollowCommand, FollowsTimePointsInBothDirections) {
  // Volumes of a 4D file in NIfTI: 1, 1.05, 1.1 times the radius, 40 ms apart.
  Volume first = image_of(Eigen::Vector3d::Zero(), kRadius);
  write_volume(path("series.nii"), first);
  std::string file = text_of("series.nii");
  const std::string header = file.substr(0, file.size() - first.bytes());
  std::string voxels;
  for (const double factor : {1.0, 1.05, 1.1}) {
    const Volume volume = image_of(Eigen::Vector3d::Zero(), factor * kRadius);
    voxels.append(static_cast<const char*>(volume.data()), volume.bytes());
  }
  std::string changed = header;
  const auto put = [&](std::size_t at, auto value) { std::memcpy(changed.data() + at, &value, sizeof value); };
  put(40, std::int16_t{4}), put(48, std::int16_t{3}), put(92, 40.0f), changed[123] = 2 + 16;
  write("series.nii", changed + voxels);
  nlohmann::json scene = json_of("first.json");
  scene["volume"] = path("series.nii"), scene["volume_number"] = 2;
  scene.erase("volume_checksum");
  write_scene("second.json", scene);
  succeed({"follow", path("second.json"), path("series.nii"), path("points"), "--time-points", "--curve",
           path("curve.csv"), "--plot", path("curve.png"), "--report", path("report.json")});
  const nlohmann::json points = json_of("report.json")["time_points"];
  ASSERT_EQ(points.size(), 3u);
  for (int p = 0; p < 3; ++p) {
    EXPECT_EQ(points[p]["time_point"], p + 1);
    EXPECT_NEAR(points[p]["time_s"].get<double>(), 0.04 * p, 1e-6);
    const SceneFile saved = read_scene(points[p]["scene"].get<std::string>());
    EXPECT_EQ(saved.scene.volume_number, p + 1);
  }
  const auto volume_ml = [&](int p) { return points[p]["objects"][0]["volume_ml"].get<double>(); };
  EXPECT_NEAR(volume_ml(2) / volume_ml(0), std::pow(1.1, 3), 0.1);
  EXPECT_TRUE(exists("curve.png"));
  EXPECT_EQ(text_of("curve.csv").substr(0, 17), "time_point,time_s");
}

TEST(TimesOfVolumes, FollowFromTheirNamesInMilliseconds) {
  DicomVolumes volumes;
  volumes.names = {"trigger time 0", "trigger time 40.5"};
  EXPECT_EQ(times_of(volumes), (std::vector<double>{0, 0.0405}));
  volumes.names = {"trigger time 0", "echo time 40"};
  EXPECT_TRUE(times_of(volumes).empty());
  volumes.names = {"trigger time 0, echo time 4"};
  EXPECT_TRUE(times_of(volumes).empty()) << "a second trait is no time";
}

TEST_F(FollowCommand, RefusesWhatCannotWork) {
  const std::string scene = path("first.json"), next = path("next.nii.gz"), out = path("next.json");
  EXPECT_NE(refusal({"follow", path("marks.json"), next, out, "--to", "none"}).find("no surface yet"),
            std::string::npos);
  EXPECT_NE(refusal({"follow", scene, next, out, "--to", "rigid", "--transform", path("shift.tfm")}).find("omit one"),
            std::string::npos);
  EXPECT_NE(refusal({"follow", scene, next, out, "--curve", path("c.csv")}).find("--time-points"), std::string::npos);
  EXPECT_NE(refusal({"follow", scene, next, out, "--field", path("f.nii.gz")}).find("displacement"), std::string::npos);
  EXPECT_NE(refusal({"follow", scene, next, path("folder"), "--time-points"}).find("one volume"), std::string::npos);
  EXPECT_NE(refusal({"follow", scene, next, path("out.txt"), "--to", "none"}).find(".json"), std::string::npos);
  EXPECT_NE(refusal({"follow", scene, path("missing.nii"), out, "--to", "none"}).find("missing.nii"),
            std::string::npos);
  write_transform(path("far.tfm"), Transform(Eigen::Affine3d(Eigen::Translation3d(500, 0, 0))));
  EXPECT_NE(refusal({"follow", scene, next, out, "--transform", path("far.tfm")}).find("none of them lies"),
            std::string::npos);
  EXPECT_FALSE(exists("next.json"));
}

}  // namespace
}  // namespace simplexseg
