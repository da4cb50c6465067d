// SPDX-License-Identifier: Apache-2.0
// Subcommand follow: scene, tables and curve, files that can be read again, and refused options.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cli_fixture.h"
#include "core/error.h"
#include "io/dicom/dicom_volumes.h"
#include "io/platform/worker_program.h"
#include "io/scene/scene_io.h"
#include "io/transform/transform_io.h"
#include "io/volume/volume_io.h"
#include "support/follow_images.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kShift(6, -4, 2);

class FollowCommand : public Cli {
 protected:
  void SetUp() override {
    Cli::SetUp();
    write_volume(path("first.nii.gz"), lesion_image(Eigen::Vector3d::Zero(), kLesionRadius));
    write_volume(path("next.nii.gz"), lesion_image(kShift, kLesionRadius * 1.1));
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
  EXPECT_LT((found(kLesionCentre) - kLesionCentre - kShift).norm(), 1);
  EXPECT_LT(json_of("report.json")["objects"][0]["shift_mm"].get<double>(), 1.2);
  EXPECT_LT(json_of("report.json")["registration"]["metric_after"],
            json_of("report.json")["registration"]["metric_before"]);
}

TEST_F(FollowCommand, FollowsTimePointsInBothDirections) {
  std::vector<Volume> volumes;
  for (const double factor : {1.0, 1.05, 1.1})
    volumes.push_back(lesion_image(Eigen::Vector3d::Zero(), factor * kLesionRadius));
  write_series(path("series.nii"), volumes, 40);
  nlohmann::json scene = json_of("first.json");
  scene["volume"] = path("series.nii"), scene["volume_number"] = 2;
  scene.erase("volume_checksum");
  write_scene("second.json", scene);
  succeed({"follow", path("second.json"), path("series.nii"), path("points"), "--time-points", "--to", "none",
           "--curve", path("curve.csv"), "--plot", path("curve.png"), "--report", path("report.json")});
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

TEST_F(FollowCommand, FollowsTimePointsByADisplacementField) {
  try {
    path_of_program(kRegisterProgram);
  } catch (const Error&) {
    GTEST_SKIP() << "built without ITK";
  }
  // The surface of each volume is that of the first one, mapped by a field between these two volumes.
  write_series(path("series.nii"),
               {lesion_image(Eigen::Vector3d::Zero(), kLesionRadius), lesion_image({2, 0, 0}, kLesionRadius),
                lesion_image({2, 0, 0}, 0.85 * kLesionRadius)},
               40);
  nlohmann::json scene = json_of("first.json");
  scene["volume"] = path("series.nii"), scene["volume_number"] = 1;
  scene.erase("volume_checksum");
  write_scene("one.json", scene);
  succeed({"follow", path("one.json"), path("series.nii"), path("points"), "--time-points", "--report",
           path("report.json")});
  const nlohmann::json points = json_of("report.json")["time_points"];
  const auto volume_ml = [&](int p) { return points[p]["objects"][0]["volume_ml"].get<double>(); };
  // Within a third of a voxel of the radius; without an effect the ratio would be 1 and the centroid the same.
  EXPECT_NEAR(volume_ml(1) / volume_ml(0), 1, 0.15);
  EXPECT_NEAR(volume_ml(2) / volume_ml(0), std::pow(0.85, 3), 0.15);
  EXPECT_NEAR(
      points[2]["objects"][0]["centroid_mm"][0].get<double>() - points[0]["objects"][0]["centroid_mm"][0].get<double>(),
      2, 0.5);
  EXPECT_EQ(read_scene(points[2]["scene"].get<std::string>()).scene.meshes[0].start->error_mm, 0);
}

TEST_F(FollowCommand, TimePointsHaveTheFiltersOfTheScene) {
  write_series(
      path("series.nii"),
      {lesion_image(Eigen::Vector3d::Zero(), kLesionRadius), lesion_image(Eigen::Vector3d::Zero(), kLesionRadius)}, 40);
  nlohmann::json scene = json_of("marks.json");
  scene["volume"] = path("series.nii");
  scene["preprocessing"] = {{"filters", {{{"name", "suv"}, {"factor", 0.5}}}}};
  write_scene("halved.json", scene);
  succeed({"run", path("halved.json"), "--until-settled", "--save", path("settled.json")});
  succeed({"follow", path("settled.json"), path("series.nii"), path("points"), "--time-points", "--to", "none",
           "--report", path("report.json")});
  const nlohmann::json points = json_of("report.json")["time_points"];
  ASSERT_EQ(points.size(), 2u);
  const auto volume_ml = [&](int p) { return points[p]["objects"][0]["volume_ml"].get<double>(); };
  EXPECT_NEAR(volume_ml(1) / volume_ml(0), 1, 0.02);
  const Scene saved = read_scene(points[1]["scene"].get<std::string>()).scene;
  ASSERT_EQ(saved.volume_preprocessing.filters.size(), 1u);
  EXPECT_EQ(saved.volume_preprocessing.filters[0].kind, FilterKind::Uptake);
  succeed({"run", points[1]["scene"].get<std::string>(), "--steps", "5"});
  // A transform would act between all volumes.
  EXPECT_NE(refusal({"follow", path("settled.json"), path("series.nii"), path("points"), "--time-points", "--transform",
                     path("shift.tfm")})
                .find("--time-points"),
            std::string::npos);
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
