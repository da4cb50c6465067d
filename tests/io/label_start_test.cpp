// SPDX-License-Identifier: Apache-2.0
#include <limits>

#include "image/label_surface.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "image/surface_error.h"
#include "io/labels/labels_io.h"
#include "io/mesh/mesh_io.h"
#include "io/scene/load_input.h"
#include "io/scene/log_io.h"
#include "io/scene/mesh_start.h"
#include "io/scene/scene_io.h"
#include "io/volume/volume_io.h"
#include "session/mesh_lifecycle.h"
#include "structure_set.h"
#include "test_files.h"

namespace simplexseg {
namespace {

using test::data_folder;
using test::error_of;

/// Label volume with two balls of label 3, the larger first along i, and a box of label 7.
class LabelStarts : public test::FolderTest {
 protected:
  LabelStarts() {
    VolumeGeometry grid;
    grid.size = {40, 24, 24};
    grid.origin_mm = {-20, 5, 7};
    labels_ = Volume(grid, VoxelType::UInt8);
    const auto voxels = labels_.voxels<std::uint8_t>();
    std::size_t v = 0;
    for (int k = 0; k < 24; ++k)
      for (int j = 0; j < 24; ++j)
        for (int i = 0; i < 40; ++i, ++v) {
          const Eigen::Vector3d p(i, j, k);
          if ((p - Eigen::Vector3d(10, 12, 12)).norm() < 8 || (p - Eigen::Vector3d(30, 12, 12)).norm() < 5)
            voxels[v] = 3;
          else if (i > 35 && j < 4)
            voxels[v] = 7;
        }
    write_labels(folder / "labels.nii.gz", labels_);
  }
  std::filesystem::path write_scene_file(const std::string& mesh) {
    return write("scene.json",
                 R"({"simplexseg_scene": 1, "volume": "labels.nii.gz", "meshes": [{"name": "a", )" + mesh + "}]}");
  }
  MeshItem item_of(const std::string& mesh) { return read_scene(write_scene_file(mesh)).scene.meshes.at(0); }
  std::string refusal_of(const std::string& mesh) {
    return error_of([&] { read_scene(write_scene_file(mesh)); });
  }
  Mask mask(double label) const { return mask_of(labels_, label); }

  Volume labels_;
};

constexpr const char* kStart = R"("start": {"labels": "labels.nii.gz", "label": 3})";

TEST_F(LabelStarts, AMeshStartsFromItsLabelAndIsResetToIt) {
  MeshItem item = item_of(kStart);
  ASSERT_TRUE(item.start && item.start->mesh);
  EXPECT_TRUE(mask(3).voxels[labels_.offset(10, 12, 12)]);
  EXPECT_LT((item.seed.centre_mm - Eigen::Vector3d(-10, 17, 19)).norm(), 1.5) << "in the larger ball";
  EXPECT_NEAR(item.seed.radius_mm, 7.5, 1);
  const SimulationParameters simulation = default_simulation_parameters();
  complete(item, simulation, labels_);
  EXPECT_GT(dice(mask(3), rasterise(item.mesh, labels_.geometry())), 0.98);
  EXPECT_TRUE(is_finest(item, simulation, 1)) << "nothing is refined";
  for (Eigen::Vector3f& p : item.mesh.positions) p *= 2;
  restart(item, simulation, labels_);
  EXPECT_EQ(item.mesh.positions, item.start->mesh->positions);
}

TEST_F(LabelStarts, PartVerticesAndSeedAreReadFromTheFile) {
  const MeshItem whole = item_of(kStart);
  const MeshItem part =
      item_of(R"("start": {"labels": "labels.nii.gz", "label": 3, "part": 2}, "final_vertices": 320)");
  EXPECT_EQ(topology_of(*whole.start->mesh).surfaces, 2);
  EXPECT_EQ(topology_of(*part.start->mesh).surfaces, 1);
  EXPECT_NEAR(part.start->mesh->vertex_count(), 320, 64);
  EXPECT_LT((part.seed.centre_mm - Eigen::Vector3d(10, 17, 19)).norm(), 1.5);
  const MeshItem own =
      item_of(std::string(kStart) +
              R"(, "sphere": {"centre_mm": [1, 2, 3], "radius_mm": 4}, "forces": {"smoothing": {"weight": 3}})");
  EXPECT_EQ(own.seed.centre_mm, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(own.parameters.weight(ForceId::Smoothing), 3);
}

TEST_F(LabelStarts, ASavedSceneHasTheSameStart) {
  Scene scene = read_scene(write_scene_file(kStart)).scene;
  complete(scene.meshes[0], scene.simulation, labels_);
  const SimplexMesh begun = scene.meshes[0].mesh;
  for (Eigen::Vector3f& p : scene.meshes[0].mesh.positions) p[0] += 1;
  write_scene(folder / "saved.json", scene);
  const MeshItem item = read_scene(folder / "saved.json").scene.meshes.at(0);
  EXPECT_EQ(item.mesh.positions, scene.meshes[0].mesh.positions) << "the pose";
  ASSERT_TRUE(item.start);
  EXPECT_EQ(item.start->mesh->positions, begun.positions) << "the start";
  EXPECT_TRUE(item.rebuilt);
}

TEST_F(LabelStarts, AMeshCanStartFromAMeshFile) {
  write_mesh(folder / "ball.ply", make_sphere({-3, 14, 20}, 6, 2));
  MeshItem item = item_of(R"("start": {"mesh": "ball.ply"})");
  ASSERT_TRUE(item.start && item.start->mesh);
  EXPECT_EQ(item.start->mesh->vertex_count(), 320);
  EXPECT_LT((item.seed.centre_mm - Eigen::Vector3d(-3, 14, 20)).norm(), 0.5);
  EXPECT_NEAR(item.seed.radius_mm, 6, 0.5);
  Scene scene = read_scene(folder / "scene.json").scene;
  write_scene(folder / "again.json", scene);
  EXPECT_EQ(read_scene(folder / "again.json").scene.meshes.at(0).start->mesh->positions, item.start->mesh->positions);
  EXPECT_NE(refusal_of(R"("start": {"mesh": "ball.ply", "label": 3})").find("delete one"), std::string::npos);
}

TEST_F(LabelStarts, ALogContainsTheStartOfAMesh) {
  const MeshItem item = item_of(kStart);
  MeshStart start = *item.start;
  start.path = (folder / "labels.nii.gz").string();
  const AddMesh add{"vertebra", item.seed, {}, 0, start};
  const Reference reference{"truth.nii.gz", 3};
  write_log(folder / "log.json",
            {{0, add}, {2, SetReference{1, reference, true}}, {0, SetReference{1, {}}}, {1, ResizePoint{4, 2.5, true}}},
            0);
  const LogFile file = read_log(folder / "log.json");
  ASSERT_EQ(file.log.size(), 4u);
  const auto& again = std::get<AddMesh>(file.log[0].command);
  ASSERT_TRUE(again.start && again.start->mesh);
  EXPECT_EQ(again.start->mesh->positions, item.start->mesh->positions);
  EXPECT_EQ(again.start->value, 3);
  const auto& set = std::get<SetReference>(file.log[1].command);
  EXPECT_TRUE(set.reference && set.reference->labels == "truth.nii.gz" && set.reference->value == 3 && set.continues);
  EXPECT_FALSE(std::get<SetReference>(file.log[2].command).reference);
  const auto& resize = std::get<ResizePoint>(file.log[3].command);
  EXPECT_TRUE(resize.point == 4 && resize.radius_mm == 2.5 && resize.continues);
}

TEST_F(LabelStarts, LabelsAreCountedWithTheirNames) {
  const std::vector<LabelCount> labels = count_labels(labels_, {{7, "box", {1, 2, 3}}});
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].value, 3);
  EXPECT_EQ(labels[1].value, 7);
  EXPECT_EQ(labels[1].name, "box");
  EXPECT_EQ(labels[1].voxels, 4u * 4 * 24);
  EXPECT_NEAR(labels[1].millilitres, 4 * 4 * 24 / 1000.0, 1e-9);
  EXPECT_EQ(count_labels(labels_, {}, 1).at(0).value, 3) << "the largest label";
}

TEST_F(LabelStarts, NearlyWholeLabelsAreRounded) {
  Volume rescaled(labels_.geometry(), VoxelType::Float32);
  for (std::size_t v = 0; v < rescaled.geometry().voxel_count(); ++v)
    rescaled.voxels<float>()[v] = static_cast<float>(labels_.voxels<std::uint8_t>()[v]) * 1.0000153f;
  rescaled.voxels<float>()[0] = std::numeric_limits<float>::quiet_NaN();
  write_volume(folder / "rescaled.nii.gz", rescaled);
  const LoadedLabels loaded = load_labels(folder / "rescaled.nii.gz");
  const std::vector<LabelCount> labels = count_labels(loaded.volume, {}), whole = count_labels(labels_, {});
  ASSERT_EQ(labels.size(), 2u);
  EXPECT_EQ(labels[0].value, 3);
  EXPECT_EQ(labels[0].voxels, whole[0].voxels);
  EXPECT_EQ(labels[1].value, 7);
  EXPECT_HAS(loaded.warnings.back(), "not exactly whole numbers and are rounded");
  EXPECT_EQ(item_of(R"("start": {"labels": "rescaled.nii.gz", "label": 3})").start->value, 3);
}

TEST_F(LabelStarts, FractionsAreRejectedOrTakenAtAThreshold) {
  Volume map(labels_.geometry(), VoxelType::Float32);
  for (std::size_t v = 0; v < map.geometry().voxel_count(); ++v)
    map.voxels<float>()[v] = labels_.voxels<std::uint8_t>()[v] == 3 ? 0.75f : 0.25f;
  write_volume(folder / "map.nii.gz", map);
  EXPECT_HAS(error_of([&] { load_labels(folder / "map.nii.gz"); }), "it is not labels");
  EXPECT_HAS(error_of([&] { load_labels(folder / "map.nii.gz"); }), "for example 0.25");
  EXPECT_HAS(refusal_of(R"("start": {"labels": "map.nii.gz"})"), "threshold");
  const std::size_t inside = count_labels(labels_, {})[0].voxels;
  const std::vector<LabelCount> half = count_labels(load_labels(folder / "map.nii.gz", {.threshold = 0.5}).volume, {});
  ASSERT_EQ(half.size(), 1u);
  EXPECT_EQ(half[0].value, 1);
  EXPECT_EQ(half[0].voxels, inside);
  const LoadedLabels chosen = load_labels(folder / "map.nii.gz", {.label = 3, .threshold = 0.75});
  EXPECT_EQ(count_labels(chosen.volume, {}).at(0).value, 3);
  EXPECT_HAS(error_of([&] { load_labels(folder / "map.nii.gz", {.threshold = 0.8}); }), "the largest value is 0.75");
  // Whole numbers are labels: a threshold that would change them is not applied.
  EXPECT_TRUE(load_labels(folder / "labels.nii.gz", {.threshold = 0.5}).warnings.empty());
  EXPECT_HAS(load_labels(folder / "labels.nii.gz", {.threshold = 5}).warnings.at(0), "threshold 5 is not applied");
}

TEST_F(LabelStarts, ReportedLabelsOfFloatsAreWhole) {
  const std::filesystem::path reports = data_folder() / "reports";
  REQUIRE_DATA(reports);
  const LoadedLabels rescaled = load_labels(reports / "lab_float.nii.gz");
  const LoadedLabels whole = load_labels(reports / "lab_int.nii.gz");
  EXPECT_EQ(mask_of(rescaled.volume, 3).voxels, mask_of(whole.volume, 3).voxels);
  EXPECT_EQ(mask_of(rescaled.volume, 1).voxels, mask_of(whole.volume, 1).voxels);
  EXPECT_EQ(count_labels(rescaled.volume, {}).size(), 2u);
}

TEST_F(LabelStarts, MissingContoursAreAWarning) {
  const Eigen::Isometry3d place(Eigen::Translation3d(0, 17, 19));
  write("rt.dcm", test::structure_set_of_squares(place, {{"gap", 8, {-4, -2, 2, 4}}, {"whole", 8, {-2, 0, 2}}}));
  const std::string gap = R"("start": {"labels": "rt.dcm", "label": "gap"})";
  const std::vector<std::string> warnings = load_scene(write_scene_file(gap)).warnings;
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_HAS(warnings[0], "rt.dcm': 1 slice between the first and the last has no contour");
  EXPECT_TRUE(load_scene(write_scene_file(R"("start": {"labels": "rt.dcm", "label": "whole"})")).warnings.empty());
  EXPECT_EQ(load_start({"rt.dcm", 1, 0, nullptr}, folder).warnings, warnings);
}

TEST_F(LabelStarts, MissingLabelsPartsAndFilesAreRejected) {
  EXPECT_HAS(refusal_of(R"("start": {"labels": "labels.nii.gz", "label": 4})"), "its labels: 3, 7");
  EXPECT_HAS(refusal_of(R"("start": {"labels": "labels.nii.gz", "label": 3, "part": 3})"), "has 2 connected parts");
  EXPECT_HAS(refusal_of(R"("start": {"labels": "labels.nii.gz", "label": 3, "part": 0})"), "start.part");
  EXPECT_HAS(refusal_of(R"("start": {"labels": "none.nii.gz"})"), "none.nii.gz");
  EXPECT_HAS(refusal_of(R"("start": {"label": 3})"), "labels");
  EXPECT_HAS(refusal_of(R"("colour": "#ffffff")"), "sphere");
  const Volume zeros(labels_.geometry(), VoxelType::UInt8);
  EXPECT_HAS(error_of([&] { choose_label(zeros, {}, "'z'"); }), "all its voxels are 0");
}

TEST_F(LabelStarts, AVertebraKeepsTheRingAroundItsCanal) {
  const std::filesystem::path path = data_folder() / "ct_abdomen" / "labels.nii.gz";
  REQUIRE_DATA(path);
  const Volume labels = read_volume(path);
  for (const int vertebra : {27, 29, 30, 31}) {
    const Mask mask = choose_label(labels, {static_cast<double>(vertebra), 1}, "labels").mask;
    for (const int vertices : {0, 1000}) {
      const SimplexMesh mesh = mesh_of_mask(mask, vertices);
      EXPECT_EQ(topology_of(mesh).surfaces, 1) << vertebra;
      EXPECT_EQ(topology_of(mesh).genus, 1) << vertebra << ", " << vertices;
      EXPECT_LT(SurfaceError(mask).of(mesh.positions).mean_mm, 0.25 * 3) << "a quarter of a voxel, " << vertebra;
      EXPECT_GT(dice(mask, rasterise(mesh, labels.geometry())), vertices ? 0.92 : 0.97) << vertebra;
    }
  }
}

}  // namespace
}  // namespace simplexseg
