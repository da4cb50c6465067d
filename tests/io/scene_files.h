// SPDX-License-Identifier: Apache-2.0
// Fixture with a folder for scene files, and a scene that uses every member and all bits.
#pragma once
#include "io/scene/scene_io.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "core/error.h"
#include "io/scene/parameter_text.h"
#include "step/simulation_parameters.h"

namespace simplexseg {

/// Fixture with a temporary folder for each test.
class SceneIo : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ =
        std::filesystem::temp_directory_path() / ("simplexseg-scene-" + std::to_string(::getpid()) + "-" +
                                                  ::testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::remove_all(folder_);
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  std::string text_of(const std::filesystem::path& path) const {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  Scene read_text(const std::string& text) const { return read_scene(write("scene.json", text)).scene; }
  /// Message of the Error for a scene text; empty if the text is valid.
  std::string refusal(const std::string& text) const {
    try {
      read_text(text);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  }

  std::filesystem::path folder_;
};

inline std::string scene_with(const std::string& rest) { return "{\"simplexseg_scene\": 1, " + rest + "}"; }
inline std::string mesh_with(const std::string& rest) {
  return scene_with("\"meshes\": [{\"name\": \"a\", \"sphere\": {\"centre_mm\": [1, 2, 3], \"radius_mm\": 4}" +
                    (rest.empty() ? "" : ", " + rest) + "}]");
}

/// Random float that needs all its digits.
inline float awkward(std::mt19937& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

/// Random value of the kind and range of a parameter.
inline float any_value(std::mt19937& random, const ParameterInfo& info) {
  if (info.kind == ParameterKind::Real) return awkward(random, info.minimum, info.maximum);
  return static_cast<float>(
      std::uniform_int_distribution<int>(static_cast<int>(info.minimum), static_cast<int>(info.maximum))(random));
}

inline ForceParameters any_forces(std::mt19937& random) {
  ForceParameters forces{};
  for (const ForceInfo& force : force_list())
    for (std::size_t p = 0; p < force.parameters.size(); ++p)
      forces.values[static_cast<int>(force.id)][p] = any_value(random, force.parameters[p]);
  return forces;
}

inline MeshItem any_item(std::mt19937& random, ItemId id, const std::string& name) {
  MeshItem item;
  item.id = id;
  item.name = name;
  item.colour = {1, 200, static_cast<std::uint8_t>(id)};
  item.visible = id % 2 == 0;
  item.label = static_cast<int>(40 + id);
  item.seed = {{0.1 * id, -1.0 / 3, 1e-17}, 10 + 1.0 / 7};
  item.reference = Reference{"truth.nii", id % 2 ? std::optional(0.1) : std::nullopt};
  item.parameters = any_forces(random);
  item.mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, 1);
  for (Eigen::Vector3f& p : item.mesh.positions) {
    p *= awkward(random, 0.99f, 1.01f);
    item.previous.push_back(p * awkward(random, 0.99f, 1.01f));
    item.shape.push_back(
        {awkward(random, -1, 1), awkward(random, -1, 1), awkward(random, -1, 1), awkward(random, 0, 1)});
    for (int s = 0; s < 9; ++s) item.profiles.push_back(awkward(random, -1000, 1000));
  }
  item.region.low = -0.1, item.region.high = 1e5 / 3;
  for (int b = 0; b < kRegionBins; ++b) item.region.object[b] = b * 7, item.region.background[b] = 1 << (b % 31);
  item.steps_at_level = 17;
  item.final_vertices = 5120;
  return item;
}

inline std::shared_ptr<const PaintVoxels> any_painted_voxels() {
  PaintVoxels voxels;
  voxels.box.size = {3, 1, 2};
  voxels.box.spacing_mm = {0.1, 1.0 / 3, 2};
  voxels.box.origin_mm = {-1.0 / 7, 2, 1e3};
  voxels.box.direction = Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  voxels.voxels = {VoxelPaint::Inside,  VoxelPaint::None,    VoxelPaint::Outside,
                   VoxelPaint::Outside, VoxelPaint::Outside, VoxelPaint::None};
  return std::make_shared<const PaintVoxels>(voxels);
}

inline Scene any_scene() {
  std::mt19937 random(5);
  Scene scene;
  scene.volume_path = "nowhere/volume.nii.gz";
  for (std::size_t p = 0; p < simplexseg::simulation_table().size(); ++p)
    value_of(scene.simulation, static_cast<int>(p)) = any_value(random, simulation_table()[p]);
  scene.forces = any_forces(random);
  scene.meshes = {any_item(random, 3, "left"), any_item(random, 4, "right . \"Ångström\"")};
  scene.points = {
      {7, 4, {0.1, 1.0 / 3, -2e-300}},
      {9, 3, {1e10, 5, 0}},
      {10, 3, {1, 2, 3}, MarkKind::Inside, 2, {0, 0, 0}, {{1e-310, 1.0 / 3, 0}, {4, 5, -6}}, {}, true},
      {11, 4, {1, 2, 4}, MarkKind::Outside, 2, {0, 0, 0}, {}, PaintBrush::ball()},
      {12, 4, {1, 2, 5}, MarkKind::Inside, 3, {0, 0, 0}, {{1, 1.0 / 7, 0}}, PaintBrush::disc({0.6, 0, 0.8}, 1.0 / 3)},
      {13,
       3,
       {1, 2, 6},
       MarkKind::Outside,
       0,
       {0, 0, 0},
       {{1, 0, 0}, {1.0 / 3, 1, 0}},
       PaintBrush::contour({0, 0, 1}, 0)},
      {14,
       3,
       {1, 2, 7},
       MarkKind::Inside,
       0,
       {0, 0, 0},
       {},
       {PaintBrush::Shape::Voxels},
       false,
       VoxelEdit::Margin,
       any_painted_voxels()},
      {15, 3, {1, 2, 8}, MarkKind::Outside, 0, {0, 0, 0}, {{1.0 / 3, 0, 0}, {0, 1, 0}}}};
  scene.points.back().lasso_normal = {0.6, 0, 0.8};
  scene.meshes[1].code = {
      {"SCT", "123037004", "Anatomical Structure"}, {"99X", "a b", "Ü"}, {"SCT", "7771000", "Left"}};
  scene.labels = {"abdomen", {{"Å \"b\"", 65535}, {"left", 1}}};
  scene.measurements = {{16, MeasurementKind::Angle, {{0.1, 1.0 / 3, -2e-300}, {4, 5, 6}, {1e7, 0, 1}}, "Cobb \"Å\""},
                        {15, MeasurementKind::Ellipse, {{1, 2, 3}, {1.1, 2, 3}, {1, 2, 1.0 / 7}}, "ellipse 1"}};
  scene.steps = 123;
  return scene;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}
template <class T>
bool same_bits(const T& a, const T& b) {
  return std::memcmp(&a, &b, sizeof(T)) == 0;
}

}  // namespace simplexseg
