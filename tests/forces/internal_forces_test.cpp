// SPDX-License-Identifier: Apache-2.0
// Smoothing and shape memory: one step compared with the formulas in double, and their invariants.
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "support/engine_fixture.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

class InternalForcesTest : public EngineTest {};
SIMPLEXSEG_ON_EVERY_BACKEND(InternalForcesTest);

Vector3d at(const SimplexMesh& mesh, int vertex) { return mesh.positions[vertex].cast<double>(); }

/// Displacement of smoothing (docs/mathematics.md, section 2.1).
Vector3d smoothing_displacement(const SimplexMesh& mesh, int i, double evenness, double curvature, double limit) {
  const Vector3d p = at(mesh, i);
  Vector3d mean = Vector3d::Zero();
  double weights = 0, lengths = 0;
  for (int k : mesh.neighbours[i]) {
    const double length = (at(mesh, k) - p).norm(), w = std::pow(length, evenness);
    mean += w * (at(mesh, k) - p), weights += w, lengths += length;
  }
  const VertexGeometry own = vertex_geometry(mesh, i);
  double elevation = 0;
  int count = 0;
  const Neighbourhood rings = neighbourhood_of(mesh, i, 2);
  for (std::size_t k = 1; k < rings.vertices.size(); ++k) {
    const VertexGeometry g = vertex_geometry(mesh, rings.vertices[k]);
    elevation += own.doubled_area_mm2 * g.elevation_mm / g.doubled_area_mm2, ++count;
  }
  const double bound = limit * lengths / 3;
  return mean / weights + curvature * std::clamp(elevation / count, -bound, bound) * own.normal;
}

/// Displacement of shape memory (docs/mathematics.md, section 2.2).
Vector3d shape_displacement(const SimplexMesh& mesh, const SimplexMesh& reference, int i, double scaling) {
  const VertexGeometry now = vertex_geometry(mesh, i), ref = vertex_geometry(reference, i);
  const double h = ref.elevation_mm * std::pow(now.doubled_area_mm2 / ref.doubled_area_mm2, scaling);
  Vector3d target = h * now.normal;
  for (int k = 0; k < 3; ++k) target += ref.metric[k] * at(mesh, mesh.neighbours[i][k]);
  return target - at(mesh, i);
}

/// Irregular mesh with convex and concave vertices.
SimplexMesh uneven_mesh() {
  SimplexMesh mesh = make_ellipsoid({5, -3, 8}, {12, 9, 20}, 2);
  for (Eigen::Vector3f& p : mesh.positions) p *= 1.0f + 0.1f * std::sin(0.4f * p[0]) * std::cos(0.3f * p[1]);
  return with_noise(mesh, 0.05 * measure(mesh).mean_edge_mm);
}

TEST_P(InternalForcesTest, SmoothingMatchesItsFormula) {
  TestScene scene;
  scene.meshes.resize(1);
  const SimplexMesh mesh = scene.meshes[0].mesh = uneven_mesh();
  const float weight = 0.6f, timestep = 0.8f;
  for (float evenness : {0.0f, 2.0f, 3.5f})
    for (float curvature : {0.0f, 1.0f})
      for (float limit : {2.0f, 0.1f}) {
        scene.meshes[0].forces = with({{"smoothing", "weight", weight},
                                       {"smoothing", "evenness", evenness},
                                       {"smoothing", "curvature", curvature},
                                       {"smoothing", "elevation_limit", limit}});
        scene.simulation = simulation(timestep, 1);
        const Positions moved = run(scene, 1);
        double worst = 0;
        for (int i = 0; i < mesh.vertex_count(); ++i) {
          const Vector3d expected =
              weight * timestep * timestep * smoothing_displacement(mesh, i, evenness, curvature, limit);
          worst = std::max(worst, (moved[i].cast<double>() - at(mesh, i) - expected).norm());
        }
        EXPECT_LT(worst, 3e-5) << "evenness " << evenness << ", curvature " << curvature << ", limit " << limit;
      }
}

TEST_P(InternalForcesTest, ShapeMemoryMatchesItsFormula) {
  TestScene scene;
  scene.meshes.resize(1);
  const SimplexMesh mesh = uneven_mesh(), reference = with_noise(make_ellipsoid({0, 0, 0}, {15, 10, 14}, 2), 0.1);
  scene.meshes[0].mesh = mesh;
  scene.meshes[0].shape = shape_reference_of(reference);
  const float weight = 0.7f, timestep = 0.9f;
  for (float scaling : {0.0f, 0.3f, 0.5f, 1.0f}) {
    scene.meshes[0].forces = with({{"shape_memory", "weight", weight}, {"shape_memory", "scaling", scaling}});
    scene.simulation = simulation(timestep, 1);
    const Positions moved = run(scene, 1);
    double worst = 0;
    for (int i = 0; i < mesh.vertex_count(); ++i) {
      const Vector3d expected = weight * timestep * timestep * shape_displacement(mesh, reference, i, scaling);
      worst = std::max(worst, (moved[i].cast<double>() - at(mesh, i) - expected).norm());
    }
    EXPECT_LT(worst, 3e-5) << "scaling " << scaling;
  }
}

TEST_P(InternalForcesTest, DampedVerletCarriesVelocity) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = make_sphere({0, 0, 0}, 10, 1);
  m.previous = m.mesh.positions;
  for (Eigen::Vector3f& p : m.previous) p -= Eigen::Vector3f(0.5f, -0.25f, 1);
  for (float damping : {0.0f, 0.25f, 1.0f}) {
    scene.simulation = simulation(1, damping);
    const float keep = 1 - damping;
    const Positions moved = run(scene, 2);
    for (int i = 0; i < m.mesh.vertex_count(); ++i) {
      const Eigen::Vector3f expected = m.mesh.positions[i] + (keep + keep * keep) * Eigen::Vector3f(0.5f, -0.25f, 1);
      ASSERT_LT((moved[i] - expected).norm(), 1e-5f);
    }
  }
}

TEST_P(InternalForcesTest, SmoothingLeavesASphereAlone) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = make_sphere({0, 0, 0}, 20, 4);
  for (float evenness : {0.0f, 2.0f}) {
    double normal[2], tangential[2];
    for (int keep = 0; keep < 2; ++keep) {
      m.forces = with({{"smoothing", "weight", 1},
                       {"smoothing", "evenness", evenness},
                       {"smoothing", "curvature", static_cast<float>(keep)},
                       {"smoothing", "elevation_limit", 2}});
      scene.simulation = simulation(1, 1);
      const Positions moved = run(scene, 1);
      normal[keep] = tangential[keep] = 0;
      for (int i = 0; i < m.mesh.vertex_count(); ++i) {
        const Vector3d p = at(m.mesh, i), d = moved[i].cast<double>() - p, n = p.normalized();
        normal[keep] += std::abs(d.dot(n)) / m.mesh.vertex_count();
        tangential[keep] += (d - d.dot(n) * n).norm() / m.mesh.vertex_count();
      }
    }
    // The remaining motion is due to the irregularity of the mesh (twelve pentagons, uneven edges). Measured: 1% of the
    // plain Laplacian along the normal, 7% of an edge within the surface.
    EXPECT_LT(normal[1], 0.02 * normal[0]) << "evenness " << evenness;
    EXPECT_LT(tangential[1], 0.1 * measure(m.mesh).mean_edge_mm) << "evenness " << evenness;
  }
}

TEST_P(InternalForcesTest, SmoothingKeepsTheVolumeOfANoisySphere) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  const double radius = 50;
  m.mesh = with_noise(make_sphere({0, 0, 0}, radius, 4), 0.02 * radius);
  const double before = 4.0 / 3.0 * M_PI * radius * radius * radius;
  for (float evenness : {0.0f, 2.0f})
    for (int keep = 0; keep < 2; ++keep) {
      m.forces = with({{"smoothing", "weight", 0.5f},
                       {"smoothing", "evenness", evenness},
                       {"smoothing", "curvature", static_cast<float>(keep)},
                       {"smoothing", "elevation_limit", 2}});
      scene.simulation = limited(1, 1);
      const double ratio = measure({run(scene, 200), m.mesh.neighbours}).volume_mm3 / before;
      // Measured: 1.0009 and 1.0010 with curvature kept; without, 0.75 (evenness 0) and, at its smaller timestep, 0.86.
      if (keep == 1) {
        EXPECT_NEAR(ratio, 1, 0.002) << "evenness " << evenness;
      } else if (evenness == 0.0f) {
        EXPECT_NEAR(ratio, 0.75, 0.05);
      } else {
        EXPECT_LT(ratio, 0.9);
      }
    }
}

TEST_P(InternalForcesTest, SmoothingHoldsOnElongatedShapes) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = make_ellipsoid({0, 0, 0}, {6, 6, 20}, 3);
  const double before = measure(m.mesh).volume_mm3;
  for (float evenness : {0.0f, 2.0f}) {
    m.forces =
        with({{"smoothing", "weight", 0.5f}, {"smoothing", "evenness", evenness}, {"smoothing", "curvature", 1}});
    scene.simulation = limited(1, 0.9f);
    const Positions end = run(scene, 2000);
    const double ratio = measure({end, m.mesh.neighbours}).volume_mm3 / before;
    // The mesh approaches a sphere and loses some volume: measured 0.71 and 0.89.
    EXPECT_GT(ratio, evenness == 0.0f ? 0.6 : 0.8) << "evenness " << evenness;
    EXPECT_LT(ratio, 1.02) << "evenness " << evenness;
    const SurfaceMeasures sphere = measure({end, m.mesh.neighbours});
    EXPECT_LT(std::pow(sphere.area_mm2, 1.5) / sphere.volume_mm3, 1.3 * std::sqrt(36 * M_PI)) << "a fold or spikes";
  }
}

TEST_P(InternalForcesTest, SmoothingRemovesFolds) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  m.mesh = make_sphere({0, 0, 0}, 20, 3);
  // A reversed patch: pushed through the surface and crossed over.
  const Neighbourhood patch = neighbourhood_of(m.mesh, 100, 3);
  const Vector3d centre = at(m.mesh, 100);
  for (int v : patch.vertices) {
    const Vector3d p = at(m.mesh, v);
    m.mesh.positions[v] = (0.8 * centre - 0.8 * (p - centre)).cast<float>();
  }
  auto folds = [&](const Positions& positions) {
    const SimplexMesh mesh{positions, m.mesh.neighbours};
    int count = 0;
    for (int i = 0; i < mesh.vertex_count(); ++i)
      for (int k : mesh.neighbours[i])
        count += vertex_geometry(mesh, i).normal.dot(vertex_geometry(mesh, k).normal) < 0;
    return count;
  };
  ASSERT_GT(folds(m.mesh.positions), 10);
  m.forces = with({{"smoothing", "weight", 0.5f}});
  scene.simulation = limited(1, 0.9f);
  const Positions end = run(scene, 500);
  EXPECT_EQ(folds(end), 0);
  const double ratio = measure({end, m.mesh.neighbours}).volume_mm3 / (4.0 / 3.0 * M_PI * 8000);
  EXPECT_GT(ratio, 0.9);
  EXPECT_LT(ratio, 1.1);
}

TEST_P(InternalForcesTest, ShapeMemoryIsZeroOnItsReference) {
  const SimplexMesh reference = with_noise(make_ellipsoid({4, 5, 6}, {30, 12, 18}, 3), 0.2);
  const Eigen::Affine3d similarity =
      Eigen::Translation3d(-9, 20, 3) * Eigen::AngleAxisd(1.1, Vector3d(1, -2, 2).normalized()) * Eigen::Scaling(1.4);
  const Eigen::Affine3d rigid =
      Eigen::Translation3d(2, -7, 11) * Eigen::AngleAxisd(2.0, Vector3d(0, 1, 1).normalized());
  auto moved_by = [&](const Eigen::Affine3d& motion, float scaling) {
    TestScene scene;
    scene.meshes.resize(1);
    TestMesh& m = scene.meshes[0];
    m.mesh = reference, m.shape = shape_reference_of(reference);
    for (Eigen::Vector3f& p : m.mesh.positions) p = (motion * p.cast<double>()).cast<float>();
    m.forces = with({{"shape_memory", "weight", 1}, {"shape_memory", "scaling", scaling}});
    return largest_distance(run(scene, 1), m.mesh.positions);
  };
  EXPECT_LT(moved_by(Eigen::Affine3d::Identity(), 0.5f), 3e-5);
  EXPECT_LT(moved_by(Eigen::Affine3d::Identity(), 0), 3e-5);
  EXPECT_LT(moved_by(rigid, 0), 5e-5);
  EXPECT_LT(moved_by(similarity, 0.5f), 5e-5);
  EXPECT_GT(moved_by(similarity, 0), 0.05);
}

TEST_P(InternalForcesTest, ShapeMemoryRestoresADeformedShape) {
  TestScene scene;
  scene.meshes.resize(1);
  TestMesh& m = scene.meshes[0];
  const SimplexMesh reference = make_ellipsoid({0, 0, 0}, {14, 9, 9}, 2);
  m.shape = shape_reference_of(reference);
  m.mesh = with_noise(reference, 0.3);
  m.forces = with({{"shape_memory", "weight", 0.9f}, {"shape_memory", "scaling", 0}});
  const Positions end = run(scene, 2000);
  // The shape is restored up to a rigid motion: the elevations agree.
  double worst = 0;
  const SimplexMesh mesh{end, reference.neighbours};
  for (int i = 0; i < mesh.vertex_count(); ++i)
    worst =
        std::max(worst, std::abs(vertex_geometry(mesh, i).elevation_mm - vertex_geometry(reference, i).elevation_mm));
  EXPECT_LT(worst, 0.05);
}

}  // namespace
}  // namespace simplexseg
