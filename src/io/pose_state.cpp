// SPDX-License-Identifier: Apache-2.0
#include "io/pose_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/expect.h"
#include "io/cbor.h"

namespace simplexseg {
using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "the arrays of a state file are little-endian");

namespace {

// A member that is added to the model must be saved too.
static_assert(sizeof(RegionModel) == 2 * sizeof(double) + 2 * kRegionBins * sizeof(std::int32_t));

template <class T>
json binary_of(const T* data, std::size_t count) {
  std::vector<std::uint8_t> bytes(count * sizeof(T));
  // Eigen says that its fixed matrices are not trivially copyable; they are numbers and nothing else.
  if (count > 0) std::memcpy(bytes.data(), static_cast<const void*>(data), bytes.size());
  return json::binary(std::move(bytes));
}

template <class T>
std::vector<T> array_of(const json& value) {
  const auto& bytes = value.get_binary();
  if (bytes.size() % sizeof(T) != 0) throw std::out_of_range("an array has a broken length");
  std::vector<T> data(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(data.data()), bytes.data(), bytes.size());
  return data;
}

void expect(bool condition, const char* what) {
  if (!condition) throw std::out_of_range(what);
}

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

void take_histogram(const json& value, std::array<std::int32_t, kRegionBins>& bins) {
  const auto counts = array_of<std::int32_t>(value);
  expect(counts.size() == bins.size(), "the region model has another number of bins");
  expect(std::all_of(counts.begin(), counts.end(), [](std::int32_t count) { return count >= 0; }),
         "the region model has a negative count");
  std::copy(counts.begin(), counts.end(), bins.begin());
}

json json_of(const std::vector<Mark>& marks) {
  std::vector<double> numbers;
  for (const Mark& m : marks) {
    numbers.push_back(static_cast<double>(m.kind));
    numbers.insert(numbers.end(), m.position_mm.begin(), m.position_mm.end());
    numbers.push_back(m.radius_mm);
    numbers.insert(numbers.end(), m.outward.begin(), m.outward.end());
  }
  return binary_of(numbers.data(), numbers.size());
}
std::vector<Mark> marks_of(const json& saved) {
  constexpr std::size_t kNumbers = 8;
  const auto numbers = array_of<double>(saved);
  expect(numbers.size() % kNumbers == 0, "the field's marks are cut short");
  std::vector<Mark> marks;
  for (std::size_t m = 0; m < numbers.size(); m += kNumbers) {
    const double* const n = numbers.data() + m;
    expect(n[0] >= 0 && n[0] <= 2, "a mark of the field has no kind");
    marks.push_back({static_cast<MarkKind>(n[0]), {n[1], n[2], n[3]}, n[4], {n[5], n[6], n[7]}});
  }
  return marks;
}

json json_of(const MeshField& field) {
  json saved = {{"first", field.box.first},
                {"size", field.box.size},
                {"values", binary_of(field.values.data(), field.values.size())},
                {"marks", json_of(field.marks)},
                {"others", json_of(field.others)},
                {"leaks", field.leaks},
                {"expected_dice", field.expected_dice}};
  if (!field.problem.empty()) saved["problem"] = field.problem;
  return saved;
}

std::shared_ptr<const MeshField> field_of(const json& saved) {
  auto field = std::make_shared<MeshField>();
  field->box = {saved.at("first").get<std::array<int, 3>>(), saved.at("size").get<std::array<int, 3>>()};
  field->values = array_of<std::uint16_t>(saved.at("values"));
  field->problem = saved.value("problem", "");
  const bool learned = field->problem.empty();
  std::size_t count = learned ? 1 : 0;
  for (const int size : field->box.size) {
    if (!learned) continue;
    expect(size > 0 && size <= 1 << 20, "the field's box has no size");
    count *= static_cast<std::size_t>(size);
  }
  expect(count == field->values.size(), "the field has another number of values than its box");
  field->marks = marks_of(saved.at("marks"));
  if (saved.contains("others")) field->others = marks_of(saved.at("others"));
  field->leaks = saved.at("leaks").get<bool>();
  if (saved.contains("expected_dice")) field->expected_dice = saved.at("expected_dice").get<float>();
  return field;
}

}  // namespace

std::uint64_t pose_digest(const SimplexMesh& mesh) {
  std::uint64_t digest = 0xcbf29ce484222325u;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(mesh.positions.data());
  for (std::size_t b = 0; b < mesh.positions.size() * sizeof(Eigen::Vector3f); ++b) {
    digest = (digest ^ bytes[b]) * 0x100000001b3u;
  }
  return digest;
}

std::string field_bytes(const MeshField& field) {
  std::string bytes;
  json::to_cbor(json_of(field), bytes);
  return bytes;
}

std::shared_ptr<const MeshField> field_of_bytes(const std::string& bytes) {
  expect_plain_cbor(bytes);
  return field_of(json::from_cbor(bytes));
}

std::string pose_state_bytes(const MeshItem& item) {
  SIMPLEXSEG_EXPECT(item.previous.empty() || item.previous.size() == item.mesh.positions.size());
  SIMPLEXSEG_EXPECT(item.shape.empty() || item.shape.size() == item.mesh.positions.size());
  json state = {
      {"simplexseg_state", 1},
      {"pose_digest", pose_digest(item.mesh)},
      {"previous", binary_of(item.previous.data(), item.previous.size())},
      {"shape", binary_of(item.shape.data(), item.shape.size())},
      {"profiles", binary_of(item.profiles.data(), item.profiles.size())},
      {"region_low", item.region.low},
      {"region_high", item.region.high},
      {"region_object", binary_of(item.region.object.data(), item.region.object.size())},
      {"region_background", binary_of(item.region.background.data(), item.region.background.size())},
      {"steps_at_level", item.steps_at_level},
      {"solver_slowest", item.solver.slowest},
      {"solver_multigrid", item.solver.multigrid},
      {"solver_hold", item.solver.support},
  };
  if (item.has_field()) {
    state["field"] = json_of(*item.field);
    if (item.fit.field == item.field) {
      state["field_disagreement"] = item.fit.disagreement;
      state["field_settled"] = item.fit.settled;
    }
  }
  state["rebuilt"] = item.rebuilt;
  std::string bytes;
  json::to_cbor(state, bytes);
  return bytes;
}

void take_pose_state(const std::string& file, const std::string& bytes, MeshItem& item) {
  try {
    expect_plain_cbor(bytes);
    const json state = json::from_cbor(bytes);
    expect(state.at("simplexseg_state").get<int>() == 1, "it has another version");
    expect(state.at("pose_digest").get<std::uint64_t>() == pose_digest(item.mesh), "it belongs to another pose");
    const std::size_t vertices = item.mesh.positions.size();

    auto previous = array_of<Eigen::Vector3f>(state.at("previous"));
    expect(previous.empty() || previous.size() == vertices, "'previous' has another number of vertices");
    expect(previous.empty() || all_finite(previous[0].data(), 3 * vertices), "'previous' is not finite");
    auto shape = array_of<Vec4>(state.at("shape"));
    expect(shape.empty() || shape.size() == vertices, "'shape' has another number of vertices");
    expect(shape.empty() || all_finite(&shape[0].x, 4 * vertices), "'shape' is not finite");
    auto profiles = array_of<float>(state.at("profiles"));
    expect(vertices == 0 ? profiles.empty() : profiles.size() % vertices == 0,
           "'profiles' has another number of vertices");
    // A sample outside the volume may be marked by a value that is not finite: profiles are taken as they are.
    RegionModel region;
    region.low = state.at("region_low").get<double>(), region.high = state.at("region_high").get<double>();
    expect(std::isfinite(region.low) && std::isfinite(region.high), "the region model's intensities are not finite");
    take_histogram(state.at("region_object"), region.object);
    take_histogram(state.at("region_background"), region.background);
    const int steps_at_level = state.at("steps_at_level").get<int>();
    expect(steps_at_level >= 0, "'steps_at_level' is negative");

    // States that were saved before solvers learnt have none of these.
    SolverState solver;
    solver.slowest = state.value("solver_slowest", 0.0f), solver.support = state.value("solver_hold", 0.0f);
    solver.multigrid = state.value("solver_multigrid", false);
    expect(std::isfinite(solver.slowest) && std::isfinite(solver.support), "the solver's state is not finite");

    // Nor have those from before fields.
    const std::shared_ptr<const MeshField> field = state.contains("field") ? field_of(state.at("field")) : nullptr;
    FieldFit fit;
    if (field && state.contains("field_settled"))
      fit = {field, state.at("field_disagreement").get<int>(), state.at("field_settled").get<bool>()};

    item.field = field, item.fit = fit, item.rebuilt = state.value("rebuilt", false);
    item.solver = solver;
    item.previous = std::move(previous);
    item.shape = std::move(shape);
    item.profiles = std::move(profiles);
    item.region = region;
    item.steps_at_level = steps_at_level;
  } catch (const json::exception&) {
    throw Error(file, "not the state file of a pose, or cut short",
                "delete the key 'state' to start again from the pose");
  } catch (const std::out_of_range& error) {
    throw Error(file, error.what(), "delete the key 'state' to start again from the pose");
  }
}

}  // namespace simplexseg
