// SPDX-License-Identifier: Apache-2.0
// Accuracy on real images: objects from one sphere each, without clicks, with one set of parameters.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>

#include "core/error.h"
#include "forces/force_list.h"
#include "gpu/backend.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "io/platform/data_path.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "mesh/mesh_geometry.h"
#include "session/session.h"
#include "step/simulation_parameters.h"
#include "study/phantom.h"

namespace simplexseg {
namespace {

const std::filesystem::path kScenes = std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "data/scenes";

/// Returns the volume with this name, or nothing if it is not on this machine. Throws Error if it cannot be read.
std::optional<Volume> volume_of(const std::string& name) {
  std::filesystem::path path;
  try {
    path = find_data(name, std::filesystem::path(SIMPLEXSEG_SOURCE_DIR) / "../shared/data");
  } catch (const Error&) {
    return std::nullopt;
  }
  return read_volume(path);
}

TEST(RealData, UnreadableLabelsAreNotReportedAsMissing) {
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "simplexseg_garbage.nii";
  std::ofstream(path) << "no labels";
  EXPECT_THROW(volume_of(path.string()), Error);
  std::filesystem::remove(path);
  EXPECT_FALSE(volume_of(path.string()).has_value());
}

std::vector<double> dice_of(const Session& session, const std::vector<Mask>& references) {
  std::vector<double> result;
  for (std::size_t k = 0; k < references.size(); ++k)
    result.push_back(dice(references[k], rasterise(session.scene().meshes[k].mesh, references[k].geometry)));
  return result;
}

/// Runs a scene file of data/scenes like the headless program.
std::optional<std::vector<double>> dice_of_scene(const char* name) {
  SceneFile file;
  try {
    file = read_scene(kScenes / name);
    if (file.volume.empty()) return std::nullopt;
  } catch (const Error& error) {
    if (std::string(error.what()).find("ct_abdomen") != std::string::npos) return std::nullopt;
    throw;
  }
  std::vector<Mask> references;
  for (const MeshItem& item : file.scene.meshes) {
    const auto labels = volume_of(item.reference->labels);
    if (!labels) return std::nullopt;
    references.push_back(mask_of(*labels, item.reference->value));
  }
  const int steps = file.scene.steps;
  Session session(make_cpu_engine());
  session.open(std::move(file.scene), read_volume(file.volume));
  const Advance done = session.advance_steps(steps);
  EXPECT_FALSE(done.failure) << *done.failure;
  return dice_of(session, references);
}

TEST(RealData, BrainOfTheHeadFromOneSphere) {
  const auto dice = dice_of_scene("ch2_brain.json");
  if (!dice) GTEST_SKIP() << "ch2 of mricron-data is not on this machine";
  EXPECT_GE((*dice)[0], 0.93);
}

/// A mesh that is folded by the field of its neighbour is rebuilt once; it does not stay folded for thousands of steps.
TEST(RealData, AdjacentOrgansSettle) {
  std::optional<Volume> image = volume_of("ct_abdomen/ct.nii.gz");
  if (!image) GTEST_SKIP() << "the CT of the abdomen is not on this machine";
  Scene scene;
  scene.simulation = default_simulation_parameters();
  Session session(make_cpu_engine(2));
  session.open(std::move(scene), std::move(*image));
  const ItemId kidney =
      session.apply(AddMesh{"right kidney", {{-80.0437, -140.3190, 316.3018}, 18.9547}, std::nullopt});
  session.apply(AddMesh{"L3", {{3.9563, -146.3190, 316.3018}, 14.9850}, std::nullopt});
  const Advance done = session.advance_steps(2000, true);
  EXPECT_TRUE(done.at_rest);
  EXPECT_TRUE(done.warnings.empty()) << done.warnings[0];
  EXPECT_LE(folded_vertices(session.scene().find_mesh(kidney)->mesh), 4);  // 12 to 41 before it was rebuilt
}

/// Bowel next to the kidney: voxels of similar appearance extend far and are not one object.
TEST(RealData, ASeedInBowelIsReported) {
  std::optional<Volume> image = volume_of("ct_abdomen/ct.nii.gz");
  if (!image) GTEST_SKIP() << "the CT of the abdomen is not on this machine";
  const std::pair<Eigen::Vector3d, const char*> seeds[] = {
      {{78.956, -164.319, 316.302}, "'bowel' spreads without finding a border"},
      {{-92.044, -179.319, 322.302}, "'bowel' is probably wrong"}};
  for (const auto& [at, warning] : seeds) {
    Scene scene;
    scene.simulation = default_simulation_parameters();
    Session session(make_cpu_engine(2));
    session.open(std::move(scene), *image);
    session.apply(AddMesh{"bowel", {at, 6}, std::nullopt});
    const Advance done = session.advance_steps(1);
    ASSERT_EQ(done.warnings.size(), 1u);
    EXPECT_NE(done.warnings[0].find(warning), std::string::npos) << done.warnings[0];
  }
}

TEST(RealData, BothKidneysTogetherFromOneSphereEach) {
  const auto dice = dice_of_scene("ct_kidneys.json");
  if (!dice) GTEST_SKIP() << "ct_abdomen is not on this machine";
  EXPECT_GE(((*dice)[0] + (*dice)[1]) / 2, 0.86) << (*dice)[0] << " and " << (*dice)[1];
}

/// Image made from a label: perfect contrast, noise of a quarter of it. All objects use the same parameters.
struct LabelCase {
  const char* labels;
  std::vector<std::optional<double>> values;
  std::vector<Seed> seeds;
  double min_dice_by_default = 0.90;  ///< smallest Dice with default parameters
};
void PrintTo(const LabelCase& c, std::ostream* out) { *out << c.labels; }

class LabelAsImage : public ::testing::TestWithParam<LabelCase> {};

void expect_found_and_stable(const LabelCase& c, const ForceParameters& parameters, double min_dice) {
  const auto labels = volume_of(c.labels);
  if (!labels) GTEST_SKIP() << c.labels << " is not on this machine";
  std::vector<Mask> references;
  Volume together(labels->geometry(), VoxelType::UInt8);
  for (const auto& value : c.values) {
    references.push_back(mask_of(*labels, value));
    for (std::size_t k = 0; k < references.back().voxels.size(); ++k)
      together.voxels<std::uint8_t>()[k] |= references.back().voxels[k];
  }
  PhantomSettings settings;
  settings.contrast = 100;
  settings.noise_sigma = 25;
  Scene scene;
  scene.simulation = default_simulation_parameters();
  for (std::size_t k = 0; k < c.seeds.size(); ++k) {
    MeshItem item;
    item.name = "object " + std::to_string(k);
    item.seed = c.seeds[k];
    item.parameters = parameters;
    scene.meshes.push_back(item);
  }
  Session session(make_cpu_engine());
  session.open(scene, image_of_label(together, 1.0, settings));
  for (int steps : {1000, 2000}) {
    const Advance done = session.advance_steps(steps);
    EXPECT_FALSE(done.failure) << *done.failure;
    for (double d : dice_of(session, references))
      EXPECT_GE(d, min_dice) << c.labels << " after " << session.total_steps() << " steps";
  }
}

/// Default parameters of a new mesh: the field is computed from the seed only.
TEST_P(LabelAsImage, IsFoundAndStableByDefault) {
  expect_found_and_stable(GetParam(), default_force_parameters(), GetParam().min_dice_by_default);
}

/// Mechanics with the simplest evidence: intensities, no field.
TEST_P(LabelAsImage, IsFoundAndStableByIntensities) {
  ForceParameters parameters = default_force_parameters();
  parameters.values[static_cast<int>(ForceId::Evidence)][EvidenceForce::source] = 1;
  parameters.values[static_cast<int>(ForceId::Smoothing)][SmoothingForce::weight] = 0.5f;
  parameters.values[static_cast<int>(ForceId::Smoothing)][SmoothingForce::curvature] = 0.5f;
  expect_found_and_stable(GetParam(), parameters, 0.90);
}

// The seeds of the kidneys have 1.5 and 2 times the radius that fits, and extend beyond the kidneys.
INSTANTIATE_TEST_SUITE_P(
    Objects, LabelAsImage,
    ::testing::Values(
        LabelCase{"ch2bet.nii.gz", {std::nullopt}, {{{-1, 21, 10}, 60}}},
        LabelCase{"ct_abdomen/labels.nii.gz", {2.0, 3.0}, {{{-71, -131, 346}, 28}, {{79, -125, 358}, 26}}, 0.88},
        LabelCase{"hippocampus/labels/hippocampus_001.nii.gz", {std::nullopt}, {{{-16, -36, 12}, 3}}},
        LabelCase{"hippocampus/labels/hippocampus_003.nii.gz", {std::nullopt}, {{{-16, -35, 13}, 3}}},
        LabelCase{"hippocampus/labels/hippocampus_004.nii.gz", {std::nullopt}, {{{-15, -34, 14}, 3}}},
        LabelCase{"hippocampus/labels/hippocampus_006.nii.gz", {std::nullopt}, {{{-13, -31, 14}, 3}}},
        LabelCase{"hippocampus/labels/hippocampus_007.nii.gz", {std::nullopt}, {{{-19, -32, 15}, 3}}}));

bool same_bits(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
}

TEST(RealData, RecordedDragReplaysBitForBitAndIsUndone) {
  const auto open = [](int threads) {
    SceneFile file = read_scene(kScenes / "ch2_brain.json");
    auto session = std::make_unique<Session>(make_cpu_engine(threads));
    session->open(std::move(file.scene), read_volume(file.volume));
    return session;
  };
  if (!volume_of("ch2.nii.gz")) GTEST_SKIP() << "ch2 of mricron-data is not on this machine";
  // Live run: the number of steps per frame depends on the time.
  const auto live = open(2);
  live->advance_steps(200);
  const MeshItem& brain = live->scene().meshes[0];
  const Eigen::Vector3d press = brain.mesh.positions[100].cast<double>();
  const Eigen::Vector3d outward = (press - brain.seed.centre_mm).normalized();
  const std::vector<Eigen::Vector3f> before = brain.mesh.positions;
  const ItemId point = live->apply(AddPoint{brain.id, press});
  for (int move = 1; move <= 30; ++move) {
    live->advance(0.002);
    live->apply(MovePoint{point, press + 0.4 * move * outward, true});
  }
  live->advance_steps(60);
  const std::vector<Eigen::Vector3f> pulled = live->scene().meshes[0].mesh.positions;
  double nearest = 1e30;
  for (const Eigen::Vector3f& p : pulled)
    nearest = std::min(nearest, (p.cast<double>() - press - 12.0 * outward).norm());
  EXPECT_LT(nearest, 1.0);  // one voxel: smoothing and image act against the point

  const std::vector<LogEntry> log = live->log();
  for (int threads : {1, 2}) {
    const auto again = open(threads);
    again->replay(log, live->steps_since_last_command());
    EXPECT_TRUE(same_bits(again->scene().meshes[0].mesh.positions, pulled)) << threads << " threads";
  }
  live->apply(Undo{});
  EXPECT_TRUE(same_bits(live->scene().meshes[0].mesh.positions, before));
  EXPECT_TRUE(live->scene().points.empty());
}

}  // namespace
}  // namespace simplexseg
