// SPDX-License-Identifier: Apache-2.0
#include "io/scene/pose_state.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/digest.h"
#include "core/error.h"
#include "core/expect.h"
#include "io/platform/cbor.h"
#include "io/scene/json_output.h"

namespace simplexseg {
using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "the arrays of a state file are little-endian");

namespace {

// Fails to compile when the model has a new member, which must be saved too.
static_assert(sizeof(RegionModel) == 2 * sizeof(double) + 2 * kRegionBins * sizeof(std::int32_t));

template <class T>
json binary_of(const T* data, std::size_t count) {
  std::vector<std::uint8_t> bytes(count * sizeof(T));
  // Fixed-size matrices of Eigen are not declared trivially copyable, but contain only numbers.
  if (count > 0) std::memcpy(bytes.data(), static_cast<const void*>(data), bytes.size());
  return json::binary(std::move(bytes));
}

template <class T>
std::vector<T> array_of(const json& value) {
  const auto& bytes = value.get_binary();
  if (bytes.size() % sizeof(T) != 0) throw std::out_of_range("the length of an array is invalid");
  std::vector<T> data(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(static_cast<void*>(data.data()), bytes.data(), bytes.size());
  return data;
}

bool all_finite(const float* values, std::size_t count) {
  return std::all_of(values, values + count, [](float value) { return std::isfinite(value); });
}

void read_histogram(const json& value, std::array<std::int32_t, kRegionBins>& bins) {
  const auto counts = array_of<std::int32_t>(value);
  expect(counts.size() == bins.size(), "the region model has a wrong number of bins");
  expect(std::all_of(counts.begin(), counts.end(), [](std::int32_t count) { return count >= 0; }),
         "the region model has a negative count");
  std::copy(counts.begin(), counts.end(), bins.begin());
}

constexpr int kMarkKinds = 3, kMarkLinks = 3;
/// First number of a mark: its kind, plus kMarkKinds times its link, plus the number of these if it is local.
int code_of(const Mark& mark) {
  return static_cast<int>(mark.kind) + kMarkKinds * (static_cast<int>(mark.link) + (mark.local ? kMarkLinks : 0));
}

json binary_json(const std::vector<Mark>& marks) {
  std::vector<double> numbers;
  for (const Mark& m : marks) {
    numbers.push_back(code_of(m));
    numbers.insert(numbers.end(), m.position_mm.begin(), m.position_mm.end());
    numbers.push_back(m.radius_mm);
    numbers.insert(numbers.end(), m.outward.begin(), m.outward.end());
  }
  return binary_of(numbers.data(), numbers.size());
}
std::vector<Mark> marks_of(const json& saved) {
  constexpr std::size_t kNumbers = 8;
  const auto numbers = array_of<double>(saved);
  expect(numbers.size() % kNumbers == 0, "the marks of the field are incomplete");
  std::vector<Mark> marks;
  for (std::size_t m = 0; m < numbers.size(); m += kNumbers) {
    const double* const n = numbers.data() + m;
    expect(n[0] >= 0 && n[0] < 2 * kMarkLinks * kMarkKinds, "a mark of the field has an invalid kind");
    const int code = static_cast<int>(n[0]);
    marks.push_back({static_cast<MarkKind>(code % kMarkKinds),
                     {n[1], n[2], n[3]},
                     n[4],
                     {n[5], n[6], n[7]},
                     static_cast<MarkLink>(code / kMarkKinds % kMarkLinks),
                     code >= kMarkKinds * kMarkLinks});
  }
  return marks;
}

json binary_json(const MeshField& painted) {
  const MeshField& field = painted.solved ? *painted.solved : painted;  // Session::open() adds the paint again
  json saved = {{"first", field.box.first},
                {"size", field.box.size},
                {"values", binary_of(field.values.data(), field.values.size())},
                {"marks", binary_json(field.marks)},
                {"others", binary_json(field.others)},
                {"leaks", field.leaks},
                {"calibrated_dice", field.expected_dice}};
  if (field.intensity_range.is_limited()) saved["intensity_range"] = range_json<json>(field.intensity_range);
  if (!field.model.empty()) saved["model"] = field.model, saved["model_trust"] = field.model_trust;
  if (field.images != 0) saved["images"] = field.images;
  if (!field.filters.empty()) saved["filters"] = field.filters;
  if (field.range_effect != RangeEffect::Limits) saved["range_effect"] = name_of(field.range_effect);
  if (field.cell != kVoxelCells) saved["cell"] = field.cell;
  if (!field.problem.empty()) saved["problem"] = field.problem;
  return saved;
}

std::shared_ptr<const MeshField> field_of(const json& saved) {
  auto field = std::make_shared<MeshField>();
  field->box = {saved.at("first").get<std::array<int, 3>>(), saved.at("size").get<std::array<int, 3>>()};
  if (saved.contains("cell")) field->cell = saved.at("cell").get<CellSize>();
  for (const double edge : field->cell) expect(edge >= 1 && edge <= 1 << 20, "the cells of the field are invalid");
  field->values = array_of<std::uint16_t>(saved.at("values"));
  field->problem = saved.value("problem", "");
  const bool solved = field->problem.empty();
  std::size_t count = solved ? 1 : 0;
  for (const int size : field->box.size) {
    if (!solved) continue;
    expect(size > 0 && size <= 1 << 20, "the box of the field has an invalid size");
    count *= static_cast<std::size_t>(size);
  }
  expect(count == field->values.size(), "the number of values of the field does not match its box");
  field->marks = marks_of(saved.at("marks"));
  if (saved.contains("others")) field->others = marks_of(saved.at("others"));
  field->model = saved.value("model", "");
  field->images = saved.value("images", std::uint64_t{0});
  field->filters = saved.value("filters", "");
  field->model_trust = saved.value("model_trust", 0.0f);
  expect(field->model_trust >= 0 && field->model_trust <= 1, "the trust in the model is out of range");
  if (saved.contains("intensity_range")) {
    const json& range = saved.at("intensity_range");
    field->intensity_range.low = range.value("low", field->intensity_range.low);
    field->intensity_range.high = range.value("high", field->intensity_range.high);
    expect(field->intensity_range.low < field->intensity_range.high, "the range of the field is empty");
  }
  if (saved.contains("range_effect"))
    field->range_effect = range_effect_of(saved.at("range_effect").get<std::string>());
  field->leaks = saved.at("leaks").get<bool>();
  if (saved.contains("calibrated_dice")) field->expected_dice = saved.at("calibrated_dice").get<float>();
  return field;
}

}  // namespace

std::uint64_t pose_digest(const SimplexMesh& mesh) {
  Digest digest;
  for (const Eigen::Vector3f& p : mesh.positions) digest.add(p.data(), 3);
  return digest.value();
}

std::string field_bytes(const MeshField& field) {
  std::string bytes;
  json::to_cbor(binary_json(field), bytes);
  return bytes;
}

std::shared_ptr<const MeshField> field_from_bytes(const std::string& bytes) {
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
      {"solver_slowest", item.solver.min_eigenvalue},
      {"solver_multigrid", item.solver.multigrid},
      {"solver_hold", item.solver.regularisation},
  };
  if (item.has_field()) {
    state["field"] = binary_json(*item.field);
    if (item.fit.field == item.field) {
      state["field_disagreement"] = item.fit.disagreement;
      state["field_settled"] = item.fit.settled;
    }
  }
  state["rebuilt"] = item.rebuilt;
  state["asleep"] = item.sleep.asleep, state["settled_steps"] = item.sleep.settled_steps;
  state["awake_steps"] = item.sleep.awake_steps, state["inputs"] = item.sleep.inputs;
  std::string bytes;
  json::to_cbor(state, bytes);
  return bytes;
}

void restore_pose_state(const std::string& file, const std::string& bytes, MeshItem& item) {
  try {
    expect_plain_cbor(bytes);
    const json state = json::from_cbor(bytes);
    expect(state.at("simplexseg_state").get<int>() == 1, "its version is not supported");
    expect(state.at("pose_digest").get<std::uint64_t>() == pose_digest(item.mesh), "it belongs to another pose");
    const std::size_t vertices = item.mesh.positions.size();

    auto previous = array_of<Eigen::Vector3f>(state.at("previous"));
    expect(previous.empty() || previous.size() == vertices, "'previous' has a wrong number of vertices");
    expect(previous.empty() || all_finite(previous[0].data(), 3 * vertices), "'previous' is not finite");
    auto shape = array_of<Vec4>(state.at("shape"));
    expect(shape.empty() || shape.size() == vertices, "'shape' has a wrong number of vertices");
    expect(shape.empty() || all_finite(&shape[0].x, 4 * vertices), "'shape' is not finite");
    auto profiles = array_of<float>(state.at("profiles"));
    expect(vertices == 0 ? profiles.empty() : profiles.size() % vertices == 0,
           "'profiles' has a wrong number of vertices");
    // Profiles are not checked: samples outside the volume may be non-finite.
    RegionModel region;
    region.low = state.at("region_low").get<double>(), region.high = state.at("region_high").get<double>();
    expect(std::isfinite(region.low) && std::isfinite(region.high),
           "the intensities of the region model are not finite");
    read_histogram(state.at("region_object"), region.object);
    read_histogram(state.at("region_background"), region.background);
    const int steps_at_level = state.at("steps_at_level").get<int>();
    expect(steps_at_level >= 0, "'steps_at_level' is negative");

    // Files of earlier versions contain no solver state.
    SolverState solver;
    solver.min_eigenvalue = state.value("solver_slowest", 0.0f),
    solver.regularisation = state.value("solver_hold", 0.0f);
    solver.multigrid = state.value("solver_multigrid", false);
    expect(std::isfinite(solver.min_eigenvalue) && std::isfinite(solver.regularisation),
           "the state of the solver is not finite");

    // Files of earlier versions contain no field.
    const std::shared_ptr<const MeshField> field = state.contains("field") ? field_of(state.at("field")) : nullptr;
    FieldFit fit;
    if (field && state.contains("field_settled"))
      fit = {field, state.at("field_disagreement").get<int>(), state.at("field_settled").get<bool>()};

    // Files of earlier versions contain no state of sleep.
    const SleepState sleep{state.value("asleep", false), state.value("settled_steps", 0), state.value("awake_steps", 0),
                           state.value("inputs", std::uint64_t{0})};
    expect(sleep.settled_steps >= 0 && sleep.awake_steps >= 0, "a number of steps is negative");

    item.field = field, item.fit = fit, item.rebuilt = state.value("rebuilt", false), item.sleep = sleep;
    item.solver = solver;
    item.previous = std::move(previous);
    item.shape = std::move(shape);
    item.profiles = std::move(profiles);
    item.region = region;
    item.steps_at_level = steps_at_level;
  } catch (const json::exception&) {
    throw Error(file, "it is not a valid state file", "delete the key 'state' in the scene to start from the pose");
  } catch (const std::out_of_range& error) {
    throw Error(file, error.what(), "delete the key 'state' in the scene to start from the pose");
  }
}

}  // namespace simplexseg
