// SPDX-License-Identifier: Apache-2.0
#include "io/model/model_file.h"

#include <zlib.h>

#include <Eigen/Cholesky>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/number_text.h"
#include "io/platform/atomic_file.h"
#include "io/platform/cbor.h"
#include "io/platform/files.h"

namespace simplexseg {
using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "the arrays of a model file are little-endian");

namespace {

/// 1: without shapes and profiles of the cases; 2: one organ.
constexpr int kVersion = 3;
constexpr const char* kHead = "simplexseg_model";

template <class T>
json array_json(const T* data, std::size_t count) {
  std::vector<std::uint8_t> bytes(count * sizeof(T));
  if (count > 0) std::memcpy(bytes.data(), static_cast<const void*>(data), bytes.size());
  return json::binary(std::move(bytes));
}
template <class T>
std::vector<T> array_from(const json& value, std::size_t count) {
  const auto& bytes = value.get_binary();
  expect(bytes.size() == count * sizeof(T), "an array has a wrong length");
  std::vector<T> data(count);
  if (count > 0) std::memcpy(static_cast<void*>(data.data()), bytes.data(), bytes.size());
  return data;
}
std::vector<float> floats_from(const json& value, std::size_t count) {
  std::vector<float> numbers = array_from<float>(value, count);
  for (const float x : numbers) expect(std::isfinite(x), "a number is not finite");
  return numbers;
}

json json_of(const Normal& n) { return {n.mean, n.deviation}; }
json json_of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
json json_of(const Normal3& n) { return {json_of(n.mean), json_of(n.deviation)}; }
double number_from(const json& value) {
  const auto number = value.get<double>();
  expect(std::isfinite(number), "a number is not finite");
  return number;
}
double positive_from(const json& value) {
  const double number = number_from(value);
  expect(number > 0, "a deviation or length is not positive");
  return number;
}
Eigen::Vector3d vector_from(const json& value) {
  return {number_from(value.at(0)), number_from(value.at(1)), number_from(value.at(2))};
}
Normal normal_from(const json& value) { return {number_from(value.at(0)), positive_from(value.at(1))}; }
Normal3 normal3_from(const json& value) {
  Normal3 normal{vector_from(value.at(0)), vector_from(value.at(1))};
  expect(normal.deviation.minCoeff() > 0, "a deviation is not positive");
  return normal;
}

json json_of(const TrainedCase& one) {
  json value{{"image", one.source.image}, {"labels", one.source.labels}};
  if (one.points.cols() == 0) return value;
  value["image_number"] = one.image_number;
  value["points_mm"] = array_json(one.points.data(), static_cast<std::size_t>(one.points.size()));
  value["profiles"] = array_json(one.profiles.data(), one.profiles.size());
  value["seed_mm"] = json_of(one.seed_mm);
  value["radius_mm"] = one.radius_mm;
  value["centre_mm"] = json_of(one.centre_mm);
  value["extent_mm"] = json_of(one.extent_mm);
  value["error_mm"] = one.error_mm;
  value["error_cases"] = one.error_cases;
  return value;
}
TrainedCase case_from(const json& value, std::size_t vertices, std::size_t number) {
  TrainedCase one;
  one.image_number = static_cast<int>(number);  // version 2 has none
  if (value.is_array()) {                       // version 1
    one.source = {value.at(0).get<std::string>(), value.at(1).get<std::string>()};
    return one;
  }
  one.source = {value.at("image").get<std::string>(), value.at("labels").get<std::string>()};
  if (!value.contains("points_mm")) return one;
  const std::vector<double> points = array_from<double>(value.at("points_mm"), 3 * vertices);
  for (const double x : points) expect(std::isfinite(x), "a number is not finite");
  one.points = Eigen::Map<const Eigen::Matrix3Xd>(points.data(), 3, static_cast<Eigen::Index>(vertices));
  one.profiles = floats_from(value.at("profiles"), vertices * TrainedCase::kStored);
  one.seed_mm = vector_from(value.at("seed_mm"));
  one.radius_mm = positive_from(value.at("radius_mm"));
  one.centre_mm = vector_from(value.at("centre_mm"));
  one.extent_mm = vector_from(value.at("extent_mm"));
  one.error_mm = number_from(value.at("error_mm"));
  one.error_cases = value.at("error_cases").get<int>();
  if (value.contains("image_number")) one.image_number = value.at("image_number").get<int>();
  expect(one.image_number >= 0, "the number of an image is negative");
  expect(one.error_mm >= 0 && one.error_cases >= 0, "an error is negative");
  return one;
}

json json_of(const OrganModel& organ) {
  const ShapeModel& shape = organ.shape;
  const ProfileModel& profiles = organ.profiles;
  json cases = json::array();
  for (const TrainedCase& one : organ.cases) cases.push_back(json_of(one));
  json curve = json::array();
  for (const UnseenError& one : organ.curve) curve.push_back({one.cases, one.error_mm});
  return {
      {"name", organ.name},
      {"modality", organ.modality},
      {"vertices", shape.vertex_count()},
      {"modes", shape.mode_count()},
      {"mean", array_json(shape.mean.positions.data(), shape.mean.positions.size())},
      {"neighbours", array_json(shape.mean.neighbours.data(), shape.mean.neighbours.size())},
      {"modes_mm", array_json(shape.modes.data(), static_cast<std::size_t>(shape.modes.size()))},
      {"pose",
       {{"log_scale", json_of(shape.pose.log_scale)},
        {"rotation", json_of(shape.pose.rotation)},
        {"from_seed_mm", json_of(shape.pose.from_seed)},
        {"from_centre_mm", json_of(shape.pose.from_centre)},
        {"log_radius", json_of(shape.pose.log_radius)},
        {"extent_mm", json_of(shape.pose.extent_mm)}}},
      {"profiles",
       {{"scale", static_cast<int>(profiles.scale)},
        {"step_mm", profiles.step_mm},
        {"cell_mm", profiles.cell_mm},
        {"surroundings_mm", profiles.surroundings_mm},
        {"mean", array_json(profiles.mean.data(), profiles.mean.size())},
        {"whitening", array_json(profiles.whitening.data(), profiles.whitening.size())}}},
      {"surface_error_mm", organ.surface_error_mm},
      {"cases", std::move(cases)},
      {"curve", std::move(curve)},
  };
}

OrganModel organ_from(const json& value) {
  OrganModel organ;
  organ.name = value.at("name").get<std::string>();
  organ.modality = value.at("modality").get<std::string>();
  const int vertices = value.at("vertices").get<int>(), modes = value.at("modes").get<int>();
  expect(vertices >= 4 && vertices <= 1'000'000 && modes >= 0 && modes <= 10'000, "a size is out of range");
  const auto count = static_cast<std::size_t>(vertices);
  ShapeModel& shape = organ.shape;
  const std::vector<float> mean = floats_from(value.at("mean"), 3 * count);
  for (std::size_t v = 0; v < count; ++v)
    shape.mean.positions.emplace_back(mean[3 * v], mean[3 * v + 1], mean[3 * v + 2]);
  shape.mean.neighbours = array_from<std::array<int, 3>>(value.at("neighbours"), count);
  validate(shape.mean);
  const std::vector<float> modes_mm = floats_from(value.at("modes_mm"), 3 * count * static_cast<std::size_t>(modes));
  shape.modes = Eigen::Map<const Eigen::MatrixXf>(modes_mm.data(), 3 * vertices, modes);
  const json& pose = value.at("pose");
  shape.pose = {normal_from(pose.at("log_scale")),     normal3_from(pose.at("rotation")),
                normal3_from(pose.at("from_seed_mm")), normal3_from(pose.at("from_centre_mm")),
                normal_from(pose.at("log_radius")),    vector_from(pose.at("extent_mm"))};
  const json& profiles = value.at("profiles");
  const int scale = profiles.at("scale").get<int>();
  expect(scale == 0 || scale == 1, "the intensity scale is unknown");
  organ.profiles.scale = static_cast<IntensityScale>(scale);
  organ.profiles.step_mm = positive_from(profiles.at("step_mm"));
  organ.profiles.cell_mm = positive_from(profiles.at("cell_mm"));
  organ.profiles.surroundings_mm = positive_from(profiles.at("surroundings_mm"));
  organ.profiles.mean = floats_from(profiles.at("mean"), count * ProfileModel::kSamples);
  organ.profiles.whitening = floats_from(profiles.at("whitening"), count * ProfileModel::kWhitening);
  organ.surface_error_mm = positive_from(value.at("surface_error_mm"));
  for (const json& one : value.at(value.contains("sources") ? "sources" : "cases"))
    organ.cases.push_back(case_from(one, count, organ.cases.size()));
  if (!value.contains("curve")) return organ;
  for (const json& one : value.at("curve")) {
    organ.curve.push_back({one.at(0).get<int>(), number_from(one.at(1))});
    expect(organ.curve.back().cases > 0 && organ.curve.back().error_mm >= 0, "an error is negative");
  }
  return organ;
}

json json_of(const PoseRelations& relations) {
  return {
      {"mean", array_json(relations.mean.data(), static_cast<std::size_t>(relations.mean.size()))},
      {"covariance", array_json(relations.covariance.data(), static_cast<std::size_t>(relations.covariance.size()))}};
}

PoseRelations relations_from(const json& value, std::size_t organs) {
  const std::size_t count = organs > 1 ? 7 * organs : 0;
  const std::vector<double> mean = array_from<double>(value.at("mean"), count),
                            covariance = array_from<double>(value.at("covariance"), count * count);
  PoseRelations relations;
  const auto size = static_cast<Eigen::Index>(count);
  relations.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), size);
  relations.covariance = Eigen::Map<const Eigen::MatrixXd>(covariance.data(), size, size);
  expect(relations.mean.allFinite() && relations.covariance.allFinite(), "a number is not finite");
  if (count > 0)
    expect(relations.covariance.isApprox(relations.covariance.transpose(), 1e-9) &&
               Eigen::LLT<Eigen::MatrixXd>(relations.covariance).info() == Eigen::Success,
           "a covariance is not positive");
  return relations;
}

std::string checksum_of_bytes(const std::string& bytes) {
  const uLong checksum = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  return "crc32-" + hexadecimal_text(checksum, 8) + "-" + std::to_string(bytes.size());
}

}  // namespace

std::string model_bytes(const ModelFile& model) {
  json organs = json::array();
  for (const OrganModel& organ : model.organs) organs.push_back(json_of(organ));
  std::string contents, bytes;
  json::to_cbor({{"organs", std::move(organs)}, {"relations", json_of(model.relations)}}, contents);
  const std::string checksum = checksum_of_bytes(contents);
  json::to_cbor({{kHead, kVersion}, {"checksum", checksum}, {"contents", array_json(contents.data(), contents.size())}},
                bytes);
  return bytes;
}

ModelFile model_from_bytes(const std::string& bytes, const std::string& name) {
  const auto damaged = [&](const std::string& why) {
    return Error("model " + name, why, "train the model again, or copy the file again");
  };
  try {
    expect_plain_cbor(bytes);
    const json file = json::from_cbor(bytes);
    if (!file.is_object() || !file.contains(kHead)) throw damaged("it is not a model of this program");
    const int version = file.at(kHead).get<int>();
    if (version < 1 || version > kVersion) throw damaged("its version is not supported");
    const auto& binary = file.at("contents").get_binary();
    const std::string contents(binary.begin(), binary.end());
    ModelFile model;
    model.checksum = checksum_of_bytes(contents);
    if (file.at("checksum").get<std::string>() != model.checksum)
      throw damaged("its checksum differs: the file is damaged");
    expect_plain_cbor(contents);
    const json read = json::from_cbor(contents);
    for (const json& organ : version < 3 ? read : read.at("organs")) model.organs.push_back(organ_from(organ));
    expect(!model.organs.empty(), "it has no organ");
    if (version >= 3) model.relations = relations_from(read.at("relations"), model.organs.size());
    expect(model.organs.size() == 1 || version >= 3, "it has several organs without relations");
    return model;
  } catch (const Error&) {
    throw;
  } catch (const std::exception& exception) {
    throw damaged("the file is damaged: " + message_of(exception));
  }
}

int organ_of_name(const ModelFile& model, const std::string& name, const std::string& file) {
  std::string names;
  for (const OrganModel& organ : model.organs) {
    if (organ.name == name) return static_cast<int>(&organ - model.organs.data());
    names += (names.empty() ? "" : ", ") + (organ.name.empty() ? "(no name)" : organ.name);
  }
  throw Error("model " + file, "it has no organ '" + one_line(name, 100) + "'",
              "choose one of its organs: " + one_line(names, 300));
}

ModelFile read_model(const std::filesystem::path& path) { return model_from_bytes(read_bytes(path), quoted(path)); }

void write_model(const std::filesystem::path& path, ModelFile& model) {
  const std::string bytes = model_bytes(model);
  AtomicFile file(path);
  write_bytes(file, bytes);
  file.commit();
  model.checksum = model_from_bytes(bytes, quoted(path)).checksum;
}

}  // namespace simplexseg
