// SPDX-License-Identifier: Apache-2.0
// Model files, tables of cases, and models in scenes and logs.
#include "io/model/model_file.h"

#include <zlib.h>

#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "io/model/case_table.h"
#include "io/scene/log_io.h"
#include "io/scene/mesh_model.h"
#include "io/scene/scene_io.h"
#include "scene_files.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::bytes_of;
using test::error_of;

/// Model with all members set; its numbers mean nothing.
ModelFile any_model() {
  OrganModel organ;
  organ.name = "Left kidney";
  organ.modality = "CT";
  organ.shape.mean = make_sphere({0, 0, 0}, 20, 1);
  const int vertices = organ.shape.vertex_count();
  organ.shape.modes = Eigen::MatrixXf::Random(3 * vertices, 3);
  organ.shape.pose = {{0.1, 0.2},  {{1, 2, 3}, {4, 5, 6}}, {{7, 8, 9}, {1, 1, 1}}, {{0, 0, 0}, {2, 2, 2}}, {-1, 0.5},
                      {10, 20, 30}};
  organ.profiles.scale = IntensityScale::Hounsfield;
  organ.profiles.step_mm = 0.7, organ.profiles.cell_mm = 1.5, organ.profiles.surroundings_mm = 30;
  organ.profiles.mean.assign(static_cast<std::size_t>(vertices) * ProfileModel::kSamples, 0.25f);
  organ.profiles.whitening.assign(static_cast<std::size_t>(vertices) * ProfileModel::kWhitening, 1.5f);
  organ.surface_error_mm = 1.25;
  TrainedCase& first = organ.cases.emplace_back();
  first.source = {"crc32-1", "crc32-2"};
  first.points = Eigen::Matrix3Xd::Random(3, vertices);
  first.profiles.assign(static_cast<std::size_t>(vertices) * TrainedCase::kStored, 0.5f);
  first.seed_mm = {1, 2, 3}, first.radius_mm = 4, first.centre_mm = {5, 6, 7}, first.extent_mm = {8, 9, 10};
  first.error_mm = 0.75, first.error_cases = 3;
  organ.curve = {{1, 2.5}, {4, 1.5}};
  organ.cases.emplace_back().source = {"crc32-3", "crc32-4"};  // as of a file without shapes
  return {{organ}, {}, ""};
}

class ModelFiles : public test::FolderTest {};

TEST_F(ModelFiles, AreReadAsTheyWereWritten) {
  ModelFile model = any_model();
  write_model(folder / "a.model", model);
  const ModelFile again = read_model(folder / "a.model");
  EXPECT_EQ(again.checksum, model.checksum);
  EXPECT_EQ(model_bytes(again), bytes_of(folder / "a.model"));
  const OrganModel &a = model.organs[0], &b = again.organs[0];
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.shape.modes, b.shape.modes);
  EXPECT_EQ(a.shape.mean.positions, b.shape.mean.positions);
  EXPECT_EQ(a.shape.mean.neighbours, b.shape.mean.neighbours);
  EXPECT_EQ(a.shape.pose.from_centre.deviation, b.shape.pose.from_centre.deviation);
  EXPECT_EQ(a.profiles.whitening, b.profiles.whitening);
  EXPECT_EQ(b.profiles.scale, IntensityScale::Hounsfield);
  ASSERT_EQ(b.cases.size(), 2u);
  EXPECT_EQ(a.cases[0].points, b.cases[0].points);
  EXPECT_EQ(a.cases[0].profiles, b.cases[0].profiles);
  EXPECT_EQ(a.cases[0].extent_mm, b.cases[0].extent_mm);
  EXPECT_EQ(b.cases[0].error_mm, 0.75);
  EXPECT_EQ(b.cases[0].error_cases, 3);
  ASSERT_EQ(b.curve.size(), 2u);
  EXPECT_EQ(b.curve[1].cases, 4);
  EXPECT_EQ(b.curve[1].error_mm, 1.5);
  EXPECT_EQ(b.cases[1].source.labels, "crc32-4");
  EXPECT_EQ(b.cases[1].points.cols(), 0);
}

TEST_F(ModelFiles, ThatAreDamagedAreRefusedInOneLine) {
  const std::string bytes = model_bytes(any_model());
  const auto reason = [&](const std::string& damaged) {
    std::ofstream(folder / "bad.model", std::ios::binary) << damaged;
    return error_of([&] { read_model(folder / "bad.model"); });
  };
  for (std::size_t at = 0; at < bytes.size(); at += bytes.size() / 97) {
    std::string damaged = bytes;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x55);
    const std::string message = reason(damaged);
    EXPECT_NE(message.find("bad.model"), std::string::npos) << at << ": " << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << at;
    if (at > 0) {
      EXPECT_NE(reason(bytes.substr(0, at)), "") << "cut after " << at << " bytes";
    }
  }
  EXPECT_NE(reason("image,labels\n").find("bad.model"), std::string::npos);
}

TEST_F(ModelFiles, WithInconsistentArraysOrNumbersAreRefused) {
  const auto reason = [&](const auto& change) {
    ModelFile model = any_model();
    change(model.organs[0]);
    std::ofstream(folder / "bad.model", std::ios::binary) << model_bytes(model);
    return error_of([&] { read_model(folder / "bad.model"); });
  };
  EXPECT_NE(reason([](OrganModel& m) { m.profiles.mean.pop_back(); }).find("wrong length"), std::string::npos);
  EXPECT_NE(reason([](OrganModel& m) { m.profiles.whitening[5] = NAN; }).find("not finite"), std::string::npos);
  EXPECT_NE(reason([](OrganModel& m) { m.shape.pose.rotation.deviation.x() = 0; }).find("deviation"),
            std::string::npos);
  EXPECT_NE(reason([](OrganModel& m) { m.shape.mean.neighbours[0][0] = 1 << 20; }), "");
  EXPECT_NE(reason([](OrganModel& m) { m.surface_error_mm = -1; }), "");
}

/// Bytes of a model file as an earlier version wrote them.
std::string bytes_of_version(int version, const ModelFile& model) {
  using nlohmann::json;
  const json file = json::from_cbor(model_bytes(model));
  const auto& binary = file.at("contents").get_binary();
  json organs = json::from_cbor(std::vector<std::uint8_t>(binary.begin(), binary.end())).at("organs");
  for (json& organ : organs) {
    for (json& one : organ["cases"]) {
      one.erase("image_number");
      if (version == 1) one = json{one["image"], one["labels"]};
    }
    if (version > 1) continue;
    organ["sources"] = organ["cases"];
    organ.erase("cases"), organ.erase("curve");
  }
  std::vector<std::uint8_t> contents = json::to_cbor(organs);
  char checksum[64];
  std::snprintf(checksum, sizeof checksum, "crc32-%08lx-%zu", crc32_z(0, contents.data(), contents.size()),
                contents.size());
  std::string bytes;
  json::to_cbor({{"simplexseg_model", version}, {"checksum", checksum}, {"contents", json::binary(contents)}}, bytes);
  return bytes;
}

TEST_F(ModelFiles, OfEarlierVersionsAreRead) {
  const ModelFile model = any_model();
  for (const int version : {1, 2}) {
    std::ofstream(folder / "old.model", std::ios::binary) << bytes_of_version(version, model);
    const ModelFile old = read_model(folder / "old.model");
    ASSERT_EQ(old.organs.size(), 1u) << version;
    EXPECT_EQ(old.organs[0].name, "Left kidney");
    EXPECT_EQ(old.organs[0].shape.modes, model.organs[0].shape.modes);
    EXPECT_EQ(old.relations.organ_count(), 0);
    ASSERT_EQ(old.organs[0].cases.size(), 2u);
    EXPECT_EQ(old.organs[0].cases[0].source.labels, "crc32-2");
    EXPECT_EQ(old.organs[0].cases[0].points.cols(), version == 1 ? 0 : model.organs[0].cases[0].points.cols());
    EXPECT_EQ(old.organs[0].cases[1].image_number, 1) << "cases of one organ are in different images";
  }
  std::ofstream(folder / "new.model", std::ios::binary) << bytes_of_version(4, model);
  EXPECT_NE(error_of([&] { read_model(folder / "new.model"); }).find("version"), std::string::npos);
}

TEST_F(ModelFiles, WithSeveralOrgansKeepTheirRelations) {
  ModelFile model = any_model();
  model.organs.push_back(model.organs[0]);
  model.organs[1].name = "Right kidney";
  model.organs[1].cases[0].image_number = 0;
  model.relations.mean = Eigen::VectorXd::LinSpaced(14, 0, 13);
  model.relations.covariance = Eigen::MatrixXd::Identity(14, 14);
  model.relations.covariance(0, 7) = model.relations.covariance(7, 0) = 0.5;
  write_model(folder / "pair.model", model);
  const ModelFile again = read_model(folder / "pair.model");
  ASSERT_EQ(again.organs.size(), 2u);
  EXPECT_EQ(again.relations.mean, model.relations.mean);
  EXPECT_EQ(again.relations.covariance, model.relations.covariance);
  EXPECT_EQ(organ_of_name(again, "Right kidney", "pair.model"), 1);
  EXPECT_NE(error_of([&] { organ_of_name(again, "Spleen", "pair.model"); }).find("Left kidney, Right kidney"),
            std::string::npos);
  // A mesh refers to one of the organs.
  const auto second = load_mesh_model((folder / "pair.model").string(), {}, model.checksum, 1);
  EXPECT_EQ(second->organ->name, "Right kidney");
  EXPECT_NE(second->identity(), load_mesh_model((folder / "pair.model").string(), {})->identity());
  write_log(folder / "log.json",
            {{0, SetModel{3, second}}, {1, SetStartModes{3, {0.5f, -2}, true}}, {0, RecordProfiles{3, true}}}, 2, "");
  const LogFile log = read_log(folder / "log.json");
  EXPECT_EQ(std::get<SetModel>(log.log[0].command).model->identity(), second->identity());
  EXPECT_EQ(std::get<SetStartModes>(log.log[1].command).modes, (std::vector<float>{0.5f, -2}));
  EXPECT_TRUE(std::get<SetStartModes>(log.log[1].command).continues);
  EXPECT_TRUE(std::get<RecordProfiles>(log.log[2].command).from_model);
  EXPECT_NE(error_of([&] { load_mesh_model((folder / "pair.model").string(), {}, "", 2); }).find("organ number 3"),
            std::string::npos);
  for (const double bad : {-1.0, double(NAN)}) {
    model.relations.covariance(3, 3) = bad;
    std::ofstream(folder / "bad.model", std::ios::binary) << model_bytes(model);
    EXPECT_NE(error_of([&] { read_model(folder / "bad.model"); }).find("bad.model"), std::string::npos);
  }
}

TEST_F(ModelFiles, AreStoredInScenesAndLogsByPathAndChecksum) {
  ModelFile model = any_model();
  write_model(folder / "kidney.model", model);
  Scene scene;
  scene.simulation = default_simulation_parameters();
  MeshItem item;
  item.name = "kidney", item.seed = {{0, 0, 0}, 5}, item.parameters = scene.forces;
  item.model = load_mesh_model((folder / "kidney.model").string(), {});
  item.start_modes = {1.5f, -0.25f};
  item.model_profiles = true;
  scene.meshes.push_back(item);
  write_scene(folder / "a.json", scene);
  EXPECT_NE(bytes_of(folder / "a.json").find("\"kidney.model\""), std::string::npos) << "relative path";
  const Scene again = read_scene(folder / "a.json").scene;
  ASSERT_TRUE(again.meshes[0].model);
  EXPECT_EQ(again.meshes[0].model_identity(), model.checksum);
  EXPECT_EQ(again.meshes[0].model->organ->name, "Left kidney");
  EXPECT_EQ(again.meshes[0].start_modes, item.start_modes);
  EXPECT_TRUE(again.meshes[0].model_profiles);

  AddMesh add{};
  add.name = "second", add.seed = {{1, 2, 3}, 4};
  add.model = item.model;
  write_log(folder / "log.json", {{0, SetModel{3, item.model}}, {1, SetModel{3, nullptr}}, {2, add}}, 5, "");
  const LogFile log = read_log(folder / "log.json");
  EXPECT_EQ(std::get<SetModel>(log.log[0].command).model->checksum, model.checksum);
  EXPECT_EQ(std::get<SetModel>(log.log[1].command).model, nullptr);
  EXPECT_EQ(std::get<AddMesh>(log.log[2].command).model->organ->cases.size(), 2u);

  model.organs[0].name = "another";
  write_model(folder / "kidney.model", model);
  EXPECT_NE(error_of([&] { read_scene(folder / "a.json"); }).find("checksum differs"), std::string::npos);
  std::filesystem::remove(folder / "kidney.model");
  EXPECT_NE(error_of([&] { read_scene(folder / "a.json"); }).find("kidney.model"), std::string::npos);
}

TEST_F(ModelFiles, AreTrainedFromTablesOfAnyUsualForm) {
  for (const char* name : {"a.nii", "a, b.nii", "labels.nii"}) std::ofstream(folder / name) << "x";
  const auto read = [&](const std::string& text) {
    std::ofstream(folder / "table.csv", std::ios::binary) << text;
    return read_case_table(folder / "table.csv");
  };
  const auto plain = read("image,labels\na.nii,labels.nii\n");
  ASSERT_EQ(plain.size(), 1u);
  EXPECT_EQ(plain[0].image, folder / "a.nii");
  EXPECT_EQ(plain[0].name, "a.nii");
  ASSERT_EQ(plain[0].organs.size(), 1u);
  EXPECT_EQ(plain[0].organs[0].labels, folder / "labels.nii");
  const auto several = read("image,labels,label\na.nii,labels.nii,2; Left kidney;4\na.nii,labels.nii,2;;4\n");
  ASSERT_EQ(several[0].organs.size(), 3u);
  EXPECT_EQ(several[0].organs[1].label, "Left kidney");
  EXPECT_EQ(several[0].organs[2].labels, folder / "labels.nii");
  EXPECT_TRUE(several[1].organs[1].labels.empty()) << "not labelled";
  EXPECT_EQ(labels_text(several[1].organs), "2;;4");
  EXPECT_EQ(files_text(several[1].organs), (folder / "labels.nii").string());
  const auto files = read("image,labels\na.nii,labels.nii;a.nii\n");
  ASSERT_EQ(files[0].organs.size(), 2u);
  EXPECT_EQ(files[0].organs[1].labels, folder / "a.nii");
  EXPECT_EQ(files[0].organs[1].label, "");
  EXPECT_FALSE(plain[0].mirror);
  const auto full = read(
      "\xef\xbb\xbfname;reference;image;reference_label;mirror\r\none;labels.nii;\"a, b.nii\";Left kidney;1\r\n\r\n");
  ASSERT_EQ(full.size(), 1u);
  EXPECT_EQ(full[0].image, folder / "a, b.nii");
  EXPECT_EQ(full[0].organs[0].label, "Left kidney");
  EXPECT_TRUE(full[0].mirror);
  const auto reason = [&](const std::string& text) { return error_of([&] { read(text); }); };
  EXPECT_NE(reason("image,mask\na.nii,labels.nii\n").find("'labels' is missing"), std::string::npos);
  EXPECT_NE(reason("image,labels\na.nii\n").find("row 2 has no labels"), std::string::npos);
  EXPECT_NE(reason("image,labels\nb.nii,labels.nii\n").find("b.nii"), std::string::npos);
  EXPECT_NE(reason("image,labels,mirror\na.nii,labels.nii,yes\n").find("mirror is 'yes'"), std::string::npos);
  EXPECT_NE(reason("image,labels\n").find("no case"), std::string::npos);
  EXPECT_NE(reason("image,labels,label\na.nii,labels.nii;a.nii,1;2;3\n").find("2 label files for 3 labels"),
            std::string::npos);
  EXPECT_NE(reason("image,labels,label\na.nii,labels.nii,1;2\na.nii,labels.nii,1\n").find("row 3 has 1 organ"),
            std::string::npos);
}

}  // namespace
}  // namespace simplexseg
