// SPDX-License-Identifier: Apache-2.0
// Final positions of a mesh on the sphere phantom under gradient, intensity profile and evidence.
#include <cmath>

#include "core/error.h"
#include "forces/region_model.h"
#include "image/metrics.h"
#include "image/rasterise.h"
#include "mesh/mesh_geometry.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

class ImageForcesTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(ImageForcesTest);

TestScene sphere_in(const Volume& volume, double radius_mm, const Vector3d& centre = {0, 0, 0}, int level = 3) {
  TestScene scene;
  scene.volume = volume;
  scene.meshes.resize(1);
  scene.meshes[0].mesh = make_sphere(centre, radius_mm, level);
  scene.simulation = simulation(1, 0.7f, 2);
  return scene;
}

double mean_radial_error(const Positions& positions, double radius_mm) {
  double sum = 0;
  for (const Eigen::Vector3f& p : positions) sum += std::abs(p.cast<double>().norm() - radius_mm);
  return sum / static_cast<double>(positions.size());
}

/// Bright sphere with a soft edge: 100 / (1 + exp((r - radius) / width)).
Volume soft_sphere(const VolumeGeometry& geometry, double radius_mm, double width_mm) {
  Volume volume(geometry, VoxelType::Float32);
  const Vector3d centre = geometry.centre_mm();
  const Eigen::Affine3d world_from_index = geometry.world_from_index();
  for (int k = 0; k < geometry.size[2]; ++k)
    for (int j = 0; j < geometry.size[1]; ++j)
      for (int i = 0; i < geometry.size[0]; ++i) {
        const double r = (world_from_index * Vector3d(i, j, k) - centre).norm();
        volume.voxels<float>()[volume.offset(i, j, k)] =
            static_cast<float>(100 / (1 + std::exp((r - radius_mm) / width_mm)));
      }
  return volume;
}

TEST_P(ImageForcesTest, GradientEndsOnTheEdge) {
  for (double radius : {17.0, 21.5})
    for (float object : {0.0f, 1.0f}) {
      TestScene scene = sphere_in(phantom("sphere").image, radius);
      scene.meshes[0].forces = with({{"gradient", "weight", 0.5f}, {"gradient", "object", object}});
      const Positions end = run(scene, 60);
      EXPECT_LT(mean_radial_error(end, kPhantomRadius), 0.2) << "from " << radius << ", object " << object;
      // |grad I| of the trilinear interpolant jumps between voxels: single vertices are off by up to half a voxel.
      EXPECT_LT(largest_radial_error(end, kPhantomRadius), object == 0.0f ? 0.5 : 0.2)
          << "from " << radius << ", object " << object;
    }
}

TEST_P(ImageForcesTest, GradientDistinguishesBrightFromDark) {
  for (double contrast : {100.0, -100.0})
    for (float object : {1.0f, 2.0f}) {
      TestScene scene = sphere_in(phantom("sphere", contrast).image, 18);
      scene.meshes[0].forces = with({{"gradient", "weight", 0.5f}, {"gradient", "object", object}});
      const Positions end = run(scene, 60);
      if ((contrast > 0) == (object == 1.0f)) {
        EXPECT_LT(largest_radial_error(end, kPhantomRadius), 0.2) << contrast << ", object " << object;
      } else {
        EXPECT_TRUE(same_bits(end, scene.meshes[0].mesh.positions)) << contrast << ", object " << object;
      }
    }
}

TEST_P(ImageForcesTest, GradientIgnoresEdgesBelowTheThreshold) {
  TestScene scene = sphere_in(phantom("sphere").image, 18);
  for (float threshold : {0.4f, 0.99f}) {
    // The edge is one voxel wide: up to the full range per voxel along an axis, less in oblique directions.
    scene.meshes[0].forces = with({{"gradient", "weight", 0.5f}, {"gradient", "threshold", threshold}});
    const double error = mean_radial_error(run(scene, 60), kPhantomRadius);
    if (threshold < 0.5f) {
      EXPECT_LT(error, 0.2);
    } else {
      EXPECT_GT(error, 1.0);
    }
  }
}

TEST_P(ImageForcesTest, GradientFindsTheEdgeInAnyGeometry) {
  // Slices of 2 mm on an oblique left-handed grid; the edge is defined in world coordinates.
  VolumeGeometry g;
  g.size = {60, 64, 32};
  g.spacing_mm = {1, 0.9, 2};
  g.direction =
      Eigen::AngleAxisd(0.6, Vector3d(1, 1, 0.3).normalized()).toRotationMatrix() * Vector3d(1, -1, 1).asDiagonal();
  g.origin_mm = Vector3d(40, -30, 15);
  const Volume volume = soft_sphere(g, 14, 0.7);
  const Vector3d centre = g.centre_mm();
  TestScene scene = sphere_in(volume, 12, centre);
  scene.meshes[0].forces = with({{"gradient", "weight", 0.5f}, {"gradient", "object", 1}});
  Positions end = run(scene, 60);
  for (Eigen::Vector3f& p : end) p -= centre.cast<float>();
  EXPECT_LT(largest_radial_error(end, 14), 0.5);
  EXPECT_LT(mean_radial_error(end, 14), 0.2);
}

TEST_P(ImageForcesTest, ProfilesReturnToTheRecordedPosition) {
  const Volume& volume = phantom("sphere", 100, 3).image;
  const SimplexMesh truth = make_sphere({0, 0, 0}, kPhantomRadius, 3);
  for (float measure : {0.0f, 1.0f})
    for (const auto& [radius, centre] : {std::pair<double, Vector3d>{kPhantomRadius - 1.5, {0, 0, 0}},
                                         {kPhantomRadius + 1.5, {0, 0, 0}},
                                         {kPhantomRadius, {1.2, -0.8, 0.4}}}) {
      TestScene scene = sphere_in(volume, radius, centre);
      TestMesh& m = scene.meshes[0];
      m.forces = with({{"intensity_profile", "weight", 0.5f},
                       {"intensity_profile", "measure", measure},
                       {"smoothing", "weight", 0.2f}});
      m.profiles = profile_reference_of(truth, volume, m.forces);
      const double before = largest_radial_error(m.mesh.positions, kPhantomRadius);
      EXPECT_GT(before, 1.2);
      const double after = largest_radial_error(run(scene, 60), kPhantomRadius);
      EXPECT_LT(after, 0.3) << "measure " << measure << ", from " << radius << " mm at " << centre.transpose();
    }
}

TEST_P(ImageForcesTest, ProfilesStayWhereTheyWereRecorded) {
  const Volume& volume = phantom("sphere", 100, 3).image;
  for (float measure : {0.0f, 1.0f}) {
    TestScene scene = sphere_in(volume, kPhantomRadius);
    TestMesh& m = scene.meshes[0];
    m.forces = with({{"intensity_profile", "weight", 1}, {"intensity_profile", "measure", measure}});
    m.profiles = profile_reference_of(m.mesh, volume, m.forces);
    EXPECT_LT(largest_distance(run(scene, 1), m.mesh.positions), 0.2) << "measure " << measure;
  }
}

TEST_P(ImageForcesTest, AProfileWithoutVarianceMatchesNothing) {
  TestScene scene = sphere_in(phantom("sphere").image, 18);
  TestMesh& m = scene.meshes[0];
  m.forces = with({{"intensity_profile", "weight", 1}, {"intensity_profile", "acceptance", -1}});
  m.profiles.assign(9 * m.mesh.positions.size(), 80.0f);
  EXPECT_TRUE(same_bits(run(scene, 5), m.mesh.positions));
}

TEST_P(ImageForcesTest, AnUnacceptableProfileDoesNotPull) {
  TestScene scene = sphere_in(phantom("sphere").image, 18);
  TestMesh& m = scene.meshes[0];
  for (float measure : {0.0f, 1.0f}) {
    m.forces = with({{"intensity_profile", "weight", 1},
                     {"intensity_profile", "measure", measure},
                     {"intensity_profile", "acceptance", measure == 0 ? 0.9f : 0.01f}});
    m.profiles.clear();  // inverted image: dark inside, bright outside
    for (float value : profile_reference_of(make_sphere({0, 0, 0}, kPhantomRadius, 3), scene.volume, m.forces))
      m.profiles.push_back(200 - value);
    EXPECT_TRUE(same_bits(run(scene, 5), m.mesh.positions)) << "measure " << measure;
  }
}

TEST_P(ImageForcesTest, RegionGrowsASeedAndShrinksAShell) {
  const Phantom& truth = phantom("sphere", 100, 10);
  const Mask object = mask_of(truth.labels, 1);
  // For the large sphere the object is within reach of the search, two edges.
  for (double radius : {7.0, 22.5}) {
    TestScene scene = sphere_in(truth.image, radius, {0.5, -0.8, 1.1});
    TestMesh& m = scene.meshes[0];
    m.forces = with({{"evidence", "weight", 0.5f}, {"smoothing", "weight", 0.5f}});
    m.region = estimate_region(scene.volume, m.mesh, 20);
    scene.simulation = limited(1, 0.9f, 3);
    const SimplexMesh end{run(scene, 400), m.mesh.neighbours};
    const double overlap = dice(object, rasterise(end, truth.image.geometry()));
    EXPECT_GT(overlap, 0.95) << "from a radius of " << radius;
  }
}

TEST_P(ImageForcesTest, BalloonGrowsAndShrinks) {
  VolumeGeometry g;
  g.size = {64, 64, 64};
  g.origin_mm.setConstant(-31.5);
  auto volume_with = [&](float balloon) {
    TestScene scene = sphere_in(soft_sphere(g, 18, 2.5), 17);
    TestMesh& m = scene.meshes[0];
    m.forces = with({{"evidence", "weight", 0.5f},
                     {"evidence", "balloon", balloon},
                     {"evidence", "local", 0},
                     {"evidence", "edge", 0},
                     {"smoothing", "weight", 0.2f}});
    m.region = estimate_region(scene.volume, make_sphere({0, 0, 0}, 18, 3), 10);
    scene.simulation = limited(1, 0.9f, 2);
    return measure({run(scene, 100), m.mesh.neighbours}).volume_mm3;
  };
  const double neutral = volume_with(0);
  EXPECT_GT(volume_with(0.5f), 1.005 * neutral);
  EXPECT_LT(volume_with(-0.5f), 0.995 * neutral);
}

TEST_P(ImageForcesTest, TargetsAreKeptBetweenRefreshes) {
  auto end_with = [&](int interval) {
    TestScene scene = sphere_in(phantom("sphere").image, 18);
    scene.meshes[0].forces = with({{"gradient", "weight", 0.2f}});
    scene.simulation = simulation(1, 1, interval);
    const auto engine = make_engine();
    simplexseg::run(*engine, scene, 12);
    std::uint64_t searches = 0;
    for (const auto& kernel : engine->kernel_counts())
      if (kernel.name == "gradient search") searches = kernel.launches;
    EXPECT_EQ(searches, static_cast<std::uint64_t>(12 / interval));
    return positions_of(*engine, scene);
  };
  EXPECT_GT(largest_distance(end_with(1), end_with(6)), 1e-4);
}

// ---- evidence from a field ----

/// Sphere of 1280 vertices on an image without contrast, with a field of the object.
TestScene field_scene(const SimplexMesh& mesh, std::vector<std::uint16_t> field) {
  TestScene scene;
  scene.volume = phantom("flat").image;
  TestMesh m;
  m.mesh = mesh;
  m.forces = with({{"smoothing", "weight", 0.3f}, {"evidence", "weight", 0.5f}, {"evidence", "source", 0}});
  m.field = std::move(field);
  scene.meshes.push_back(std::move(m));
  scene.simulation = limited(1, 0.9f, 3);
  return scene;
}

TEST_P(ImageForcesTest, AFieldDrawsTheMeshToItsSurface) {
  const VolumeGeometry& geometry = phantom("flat").image.geometry();
  for (const double start : {9.0, 24.0}) {
    const TestScene scene = field_scene(make_sphere({2, -1, 3}, start, 3), ball_field(geometry, {1, 0, 2}, 16));
    Positions end = run(scene, 400);
    for (Eigen::Vector3f& p : end) p -= Eigen::Vector3f(1, 0, 2);
    EXPECT_LT(largest_radial_error(end, 16), 0.5) << "from a radius of " << start;
  }
}

TEST_P(ImageForcesTest, HoldReducesTheEffectOfSmoothing) {
  const VolumeGeometry& geometry = phantom("flat").image.geometry();
  const auto mean_radius = [&](float smoothing, float hold) {
    TestScene scene = field_scene(make_sphere({0, 0, 0}, 5, 2), ball_field(geometry, {0, 0, 0}, 5));
    set(scene.meshes[0].forces, {"smoothing", "weight", smoothing});
    set(scene.meshes[0].forces, {"smoothing", "curvature", 0});
    set(scene.meshes[0].forces, {"evidence", "hold", hold});
    double sum = 0;
    const Positions end = run(scene, 400);
    for (const Eigen::Vector3f& p : end) sum += p.norm();
    return sum / static_cast<double>(end.size());
  };
  const double field = mean_radius(0.01f, 8), held = mean_radius(2, 8), loose = mean_radius(2, 1);
  EXPECT_NEAR(field, 5, 0.3);
  EXPECT_GT(field - loose, 0.1) << "smoothing contracts it";
  EXPECT_LT(field - held, 0.4 * (field - loose));
}

TEST_P(ImageForcesTest, AnImageEdgeBesideTheFieldsSurfaceIsFollowed) {
  // The field's ball is one voxel too small; the image edge is at the phantom's radius.
  TestScene scene = field_scene(make_sphere({0, 0, 0}, kPhantomRadius - 2, 3),
                                ball_field(phantom("sphere").image.geometry(), {0, 0, 0}, kPhantomRadius - 1));
  scene.volume = phantom("sphere").image;
  scene.meshes[0].region = estimate_region(scene.volume, scene.meshes[0].mesh, 20);
  set(scene.meshes[0].forces, {"evidence", "edge", 0});
  const double without = largest_radial_error(run(scene, 300), kPhantomRadius);
  set(scene.meshes[0].forces, {"evidence", "edge", 4});
  const double with_edge = largest_radial_error(run(scene, 300), kPhantomRadius);
  EXPECT_GT(without, 0.8);
  EXPECT_LT(with_edge, 0.85 * without);
}

TEST_P(ImageForcesTest, AFieldIsReadOnlyInItsBox) {
  // A smaller box with the same values gives identical bits; a box with half of them has no object beyond its side.
  const VolumeGeometry& geometry = phantom("flat").image.geometry();
  TestScene whole = field_scene(make_sphere({-8, 0, 0}, 5, 3), ball_field(geometry, {0, 0, 0}, 16));
  set(whole.meshes[0].forces, {"smoothing", "weight", 2});  // prevents folds, since the mesh grows far on one side
  const auto run_in_box = [&](std::array<int, 3> first, std::array<int, 3> size) {
    std::vector<std::uint16_t> values;
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i)
          values.push_back(
              whole.meshes[0].field[(std::size_t(k + first[2]) * geometry.size[1] + j + first[1]) * geometry.size[0] +
                                    i + first[0]]);
    TestScene scene = whole;
    scene.meshes[0].field.clear();
    const auto engine = make_engine();
    load(*engine, scene);
    engine->set_field(0, {kVoxelCells, {first, size}, values});
    engine->step(1500);
    return positions_of(*engine, scene);
  };
  const Positions expected = run_in_box({0, 0, 0}, geometry.size);
  EXPECT_LT(largest_distance(run_in_box({8, 8, 8}, {48, 48, 48}), expected), 1e-3);
  float highest = -100;
  for (const Eigen::Vector3f& p : run_in_box({8, 8, 8}, {24, 48, 48})) highest = std::max(highest, p[0]);
  EXPECT_LT(highest, 2.0f) << "the box ends at x = -0.5 mm";
  EXPECT_GT(std::max_element(expected.begin(), expected.end(), [](auto& a, auto& b) { return a[0] < b[0]; })->x(), 10);
}

TEST_P(ImageForcesTest, AFieldThatDoesNotFitIsRefused) {
  TestScene scene = field_scene(make_sphere({0, 0, 0}, 10, 2), {});
  const auto engine = make_engine();
  load(*engine, scene);
  const std::vector<std::uint16_t> values(8);
  EXPECT_THROW(engine->set_field(0, {kVoxelCells, {{0, 0, 0}, {2, 2, 1}}, values}), Error);
  EXPECT_THROW(engine->set_field(0, {kVoxelCells, {{63, 0, 0}, {2, 2, 2}}, values}), Error);
  EXPECT_THROW(engine->set_field(0, {kVoxelCells, {{-1, 0, 0}, {2, 2, 2}}, values}), Error);
  EXPECT_NO_THROW(engine->set_field(0, {kVoxelCells, {{62, 0, 0}, {2, 2, 2}}, values}));
}

}  // namespace
}  // namespace simplexseg
