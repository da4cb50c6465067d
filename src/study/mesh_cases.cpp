// SPDX-License-Identifier: Apache-2.0
// Stability cases: meshes of extreme size, position, shape and quality.
#include <algorithm>
#include <cmath>

#include "forces/region_model.h"
#include "image/mask.h"
#include "study/trials.h"

namespace simplexseg {
namespace {

using Eigen::Vector3d;

/// Case that runs smoothing alone on a shape for 2000 steps.
StabilityCase smoothed(const char* name, const char* what, const std::function<SimplexMesh(int)>& make,
                       float curvature) {
  return {name,
          what,
          CaseOutcome::Bounded,
          CaseOutcome::Bounded,
          "smoothing makes a shape rounder, never larger than it was; folds on the way are reported",
          [=](bool full) {
            const SimplexMesh start = make(full ? 3 : 2);
            Trial trial = trial_of(start, Volume(),
                                   forces_with({{"smoothing", "weight", 0.5f}, {"smoothing", "curvature", curvature}}));
            trial.steps = 2000;
            trial.folds = true;
            double farthest = 0;
            for (const Eigen::Vector3f& p : start.positions) farthest = std::max<double>(farthest, p.norm());
            trial.reach_mm = 1.2 * farthest;
            return trial;
          }};
}
SimplexMesh bent_ellipsoid(int level) {
  return transformed(make_ellipsoid({0, 0, 0}, {4, 4, 40}, level), [](const Vector3d& p) {
    const double angle = p[2] / 20, radius = 20 + p[0];  // an arc of 4 rad with a radius of 20 mm
    return Vector3d(radius * std::cos(angle), p[1], radius * std::sin(angle));
  });
}
SimplexMesh three_lobes(int level) {
  return transformed(make_sphere({0, 0, 0}, 1, level), [](const Vector3d& p) {
    double sum = 0;
    for (int k = 0; k < 3; ++k)
      sum += std::pow(std::max(0.0, p.dot(Vector3d(std::cos(2.094 * k), std::sin(2.094 * k), 0))), 8);
    return ((5 + 20 * sum) * p).eval();
  });
}

/// Trial of 2000 steps in which a small seed grows into a shape with refinement.
Trial grown_in(const Volume& image, const Volume& labels, const Vector3d& seed_mm, double radius_mm, bool full) {
  Trial trial = trial_of(make_sphere(seed_mm, radius_mm, 1), image, usual_forces());
  trial.scene.meshes[0].seed = {seed_mm, radius_mm};
  trial.scene.simulation.final_vertices = full ? 1280 : 320;
  trial.scene.simulation.finest_edge = 0;
  trial.steps = 2000;
  trial.error = dice_error(labels);
  trial.reach_mm = 110;
  return trial;
}
/// Position of the labelled voxel that is nearest to the mean of all labelled voxels, mm.
Vector3d central_voxel(const Volume& labels) {
  const Mask mask = mask_of(labels, std::nullopt);
  const VolumeGeometry& g = labels.geometry();
  const Eigen::Affine3d world_from_index = g.world_from_index();
  std::vector<Vector3d> inside;
  Vector3d mean = Vector3d::Zero();
  for (int k = 0; k < g.size[2]; ++k)
    for (int j = 0; j < g.size[1]; ++j)
      for (int i = 0; i < g.size[0]; ++i)
        if (mask.voxels[labels.offset(i, j, k)])
          inside.push_back(world_from_index * Vector3d(i, j, k)), mean += inside.back();
  mean /= static_cast<double>(inside.size());
  return *std::min_element(inside.begin(), inside.end(),
                           [&](const Vector3d& a, const Vector3d& b) { return (a - mean).norm() < (b - mean).norm(); });
}
const Phantom& branched_phantom() {
  static const Phantom phantom = [] {
    const auto inside = [](const Vector3d& p) {
      for (int k = 0; k < 3; ++k) {
        const Vector3d d(std::cos(2.094 * k), std::sin(2.094 * k), 0.3);
        const double t = std::clamp(p.dot(d) / d.squaredNorm(), 0.0, 22.0);
        if ((p - t * d).norm() < 5) return true;
      }
      return false;
    };
    const auto filled = [&](VoxelType type, double object, double background) {
      return volume_of(type, {64, 64, 64}, {1, 1, 1},
                       [&](const Vector3d& p) { return inside(p) ? object : background; });
    };
    return Phantom{filled(VoxelType::Int16, 150, 50), filled(VoxelType::UInt8, 1, 0)};
  }();
  return phantom;
}

/// Trial of the ball with all lengths scaled so that its radius is `radius_mm`, centred at `shift_mm`.
Trial scaled_ball(double radius_mm, const Vector3d& shift_mm) {
  const double scale = radius_mm / kBallRadius;
  Trial trial = trial_of(make_sphere(shift_mm + scale * Vector3d(1, -0.5, 0.5), 15 * scale, 2),
                         scaled_and_shifted(ball_volume(), scale, shift_mm), usual_forces());
  trial.scene.meshes[0].seed.radius_mm = 10 * scale;
  trial.error = radial_error(radius_mm, shift_mm);
  trial.tolerance = 1.5 * scale;
  trial.reach_mm = 60 * scale;
  return trial;
}

/// Case with a damaged mesh in the ball's scene; the mesh should recover from the damage.
StabilityCase damaged(const char* name, const char* what, const std::function<void(SimplexMesh&)>& damage) {
  return {name,
          what,
          CaseOutcome::Converges,
          CaseOutcome::Converges,
          "to the ball's surface within 1.5 mm: smoothing evens it out",
          [=](bool) {
            Trial trial = ball_trial();
            MeshItem& item = trial.scene.meshes[0];
            item.region = estimate_region(trial.volume, item.mesh, 30);  // estimated before the damage
            damage(item.mesh);
            trial.steps = 800;
            return trial;
          }};
}

StabilityCase refused_mesh(const char* name, const char* what, const char* refusal_text,
                           const std::function<void(MeshItem&)>& damage) {
  return {name,
          what,
          CaseOutcome::Refused,
          CaseOutcome::Refused,
          "there is no surface to move",
          [=](bool) {
            Trial trial = ball_trial();
            damage(trial.scene.meshes[0]);
            return trial;
          },
          refusal_text};
}

void invert(SimplexMesh& mesh) {
  for (auto& n : mesh.neighbours) std::swap(n[1], n[2]);
}

}  // namespace

std::vector<StabilityCase> mesh_cases() {
  std::vector<StabilityCase> cases;
  const auto add = [&](const char* name, const char* what, CaseOutcome stated, const char* reason,
                       std::function<Trial(bool)> make) {
    cases.push_back({name, what, stated, stated, reason, std::move(make)});
  };
  add("vertices_20", "the coarsest mesh there is", CaseOutcome::Converges,
      "to the ball's surface within 3.5 mm: its cells are 15 mm wide", [](bool) {
        Trial trial = ball_trial();
        trial.scene.meshes[0].mesh = make_sphere({1, -0.5, 0.5}, 15, 0);
        trial.tolerance = 3.5;
        return trial;
      });
  add("vertices_1310720", "1,310,720 vertices, edges of 0.04 mm in voxels of 2 mm (a test takes 20,480)",
      CaseOutcome::Bounded, "few steps: it moves a little and stays whole", [](bool full) {
        Trial trial = ball_trial();
        trial.scene.meshes[0].mesh = make_sphere({1, -0.5, 0.5}, 15, full ? 8 : 5);
        trial.steps = full ? 9 : 12;
        return trial;
      });
  add("tube_2000_steps", "a seed in a thin bent tube", CaseOutcome::Bounded,
      "it grows along the tube and stays in it; folds are reported", [](bool full) {
        const Phantom& tube = phantom_of("tube");
        Trial trial = grown_in(tube.image, tube.labels, central_voxel(tube.labels), 2.5, full);
        trial.folds = true;
        return trial;
      });
  add("torus_2000_steps", "a seed in a ring, which a sphere cannot become", CaseOutcome::Bounded,
      "its ends meet and stay apart; folds are reported", [](bool full) {
        const Phantom& torus = phantom_of("torus");
        Trial trial = grown_in(torus.image, torus.labels, {16, 0, 0}, 4, full);
        trial.folds = true;
        return trial;
      });
  add("two_spheres_2000_steps", "a seed between two objects", CaseOutcome::Bounded, "it takes one, both or none",
      [](bool full) {
        const Phantom& both = phantom_of("two-spheres");
        Trial trial = grown_in(both.image, both.labels, {-5, 0, 0}, 4, full);
        trial.folds = true;
        return trial;
      });
  add("branched_2000_steps", "a seed where three branches meet", CaseOutcome::Converges,
      "to the shape, Dice at least 0.8; folds are reported", [](bool full) {
        const Phantom& branched = branched_phantom();
        Trial trial = grown_in(branched.image, branched.labels, {0, 0, 0}, 4, full);
        trial.tolerance = 0.2;
        trial.folds = true;
        return trial;
      });
  for (const float curvature : {0.5f, 1.0f}) {
    const bool whole = curvature == 1;
    cases.push_back(smoothed(
        whole ? "long_ellipsoid_smoothed" : "long_ellipsoid_smoothed_half",
        "smoothing alone on an ellipsoid of 4 x 4 x 40 mm, 2000 steps",
        [](int level) {
          return make_ellipsoid({0, 0, 0}, {4, 4, 40}, level);
        },
        curvature));
    cases.push_back(smoothed(whole ? "bent_ellipsoid_smoothed" : "bent_ellipsoid_smoothed_half",
                             "smoothing alone on the same, bent to a half circle", bent_ellipsoid, curvature));
    cases.push_back(smoothed(whole ? "three_lobes_smoothed" : "three_lobes_smoothed_half",
                             "smoothing alone on a branched shape, 2000 steps", three_lobes, curvature));
  }
  cases.push_back(smoothed(
      "flat_disc_smoothed", "smoothing alone on a disc of 20 x 20 x 1 mm, 2000 steps",
      [](int level) {
        return make_ellipsoid({0, 0, 0}, {20, 20, 1}, level);
      },
      1));
  cases.push_back(
      damaged("needle_cells", "every fourth vertex at 0.1% of an edge from a neighbour", [](SimplexMesh& mesh) {
        for (int i = 0; i < mesh.vertex_count(); i += 4) {
          const Eigen::Vector3f q = mesh.positions[mesh.neighbours[i][0]];
          mesh.positions[i] = q + 0.001f * (mesh.positions[i] - q);
        }
      }));
  cases.push_back(damaged("coincident_vertices", "every seventh vertex on a neighbour", [](SimplexMesh& mesh) {
    for (int i = 0; i < mesh.vertex_count(); i += 7) mesh.positions[i] = mesh.positions[mesh.neighbours[i][0]];
  }));
  cases.push_back(
      damaged("coincident_neighbours", "the three neighbours of every 40th vertex in one place", [](SimplexMesh& mesh) {
        for (int i = 0; i < mesh.vertex_count(); i += 40) {
          const auto n = mesh.neighbours[i];
          mesh.positions[n[1]] = mesh.positions[n[2]] = mesh.positions[n[0]];
        }
      }));
  cases.push_back(
      damaged("collinear_neighbours", "the three neighbours of every 40th vertex on a line", [](SimplexMesh& mesh) {
        for (int i = 0; i < mesh.vertex_count(); i += 40) {
          const auto n = mesh.neighbours[i];
          mesh.positions[n[1]] = 0.5f * (mesh.positions[n[0]] + mesh.positions[n[2]]);
        }
      }));
  cases.push_back(damaged("squashed", "the sphere pressed to 1% of its height", [](SimplexMesh& mesh) {
    mesh = transformed(mesh, [](const Vector3d& p) { return Vector3d(p[0], p[1], 0.01 * p[2]); });
  }));
  cases.push_back(damaged("noisy_start", "noise of 0.6 edges: folded at many vertices",
                          [](SimplexMesh& mesh) { mesh = add_noise(mesh, 0.6); }));
  cases.push_back(
      damaged("folded_start", "one third of the vertices pushed through to the other side", [](SimplexMesh& mesh) {
        mesh = transformed(mesh, [](const Vector3d& p) { return Vector3d(p[0] > 6 ? 12 - p[0] : p[0], p[1], p[2]); });
      }));
  add("inside_out_at_engine", "a sphere turned inside out, smoothing alone", CaseOutcome::Bounded,
      "it stays so, and that is reported", [](bool) {
        Trial trial = ball_trial();
        invert(trial.scene.meshes[0].mesh);
        trial.scene.meshes[0].parameters = forces_with({{"smoothing", "weight", 0.5f}, {"smoothing", "curvature", 1}});
        trial.at_engine = true;
        trial.error = {};
        trial.inverted = true;
        return trial;
      });
  cases.push_back(refused_mesh("inside_out_start", "a sphere turned inside out", "counter-clockwise",
                               [](MeshItem& item) { invert(item.mesh); }));
  cases.push_back(refused_mesh("all_vertices_in_one_place", "a mesh without extent", "volume of 0", [](MeshItem& item) {
    for (Eigen::Vector3f& p : item.mesh.positions) p.setZero();
  }));
  cases.push_back(refused_mesh("vertex_nan", "a vertex that is not a number", "not finite",
                               [](MeshItem& item) { item.mesh.positions[5][1] = NAN; }));
  cases.push_back(refused_mesh("vertex_1e30", "a vertex 1e30 mm away", "", [](MeshItem& item) {
    item.mesh.positions[5] = {1e30f, 0, 0};
  }));
  cases.push_back(
      refused_mesh("seed_outside_volume", "a seed outside of the volume", "outside the image", [](MeshItem& item) {
        item.mesh = {};
        item.seed.centre_mm = {1000, 0, 0};
      }));
  cases.push_back(refused_mesh("seed_radius_0", "a seed of radius 0", "radius", [](MeshItem& item) {
    item.mesh = {};
    item.seed.radius_mm = 0;
  }));
  add("mesh_1e-3_mm", "a ball of radius 1e-3 mm", CaseOutcome::Converges,
      "to the ball's surface within 0.75 voxel: no unit is built in", [](bool) {
        return scaled_ball(1e-3, {0, 0, 0});
      });
  add("mesh_1e4_mm", "a ball of radius 1e4 mm", CaseOutcome::Converges,
      "to the ball's surface within 0.75 voxel: no unit is built in", [](bool) {
        return scaled_ball(1e4, {0, 0, 0});
      });
  add("mesh_1e6_mm_from_origin", "mesh and volume a kilometre from the origin", CaseOutcome::Converges,
      "to the ball's surface within 2.5 mm, as a float resolves 0.06 mm there", [](bool) {
        Trial trial = scaled_ball(kBallRadius, {1e6, -1e6, 1e6});
        trial.tolerance = 2.5;
        return trial;
      });
  add("mesh_1e-3_mm_with_point", "the same as mesh_1e-3_mm, with an attraction point 10% off", CaseOutcome::Converges,
      "a vertex within 2% of the radius of the point", [](bool) {
        Trial trial = scaled_ball(1e-3, {0, 0, 0});
        add_point(trial, {1.1e-3, 1e-4, 0});
        trial.error = distance_to({1.1e-3, 1e-4, 0});
        trial.tolerance = 2e-5;
        return trial;
      });
  add("mesh_1e4_mm_with_point", "the same as mesh_1e4_mm, with an attraction point 10% off", CaseOutcome::Converges,
      "a vertex within 2% of the radius of the point", [](bool) {
        Trial trial = scaled_ball(1e4, {0, 0, 0});
        add_point(trial, {1.1e4, 1e3, 0});
        trial.error = distance_to({1.1e4, 1e3, 0});
        trial.tolerance = 200;
        return trial;
      });
  add("mesh_outside_volume", "a mesh 500 mm outside of the volume", CaseOutcome::Converges,
      "to the start within 1 mm: there is no image", [](bool) {
        Trial trial = ball_trial();
        MeshItem& item = trial.scene.meshes[0];
        item.mesh = make_sphere({500, 0, 0}, 15, 2);
        item.seed = {{0, 0, 0}, 10};
        set_value(item.parameters, {"smoothing", "curvature", 1});
        trial.error = distance_from(item.mesh);
        return trial;
      });
  add("mesh_half_outside_volume", "a mesh that reaches 15 mm out of the volume", CaseOutcome::Bounded,
      "there is no object outside: it comes back or stays", [](bool) {
        Trial trial = ball_trial();
        trial.scene.meshes[0].mesh = make_sphere({32, 0, 0}, 15, 2);
        trial.scene.meshes[0].seed = {{31, 0, 0}, 10};
        trial.reach_mm = 90;
        return trial;
      });
  add("two_meshes_in_one_ball", "two meshes that start within each other", CaseOutcome::Converges,
      "the first to the ball's surface within 1.5 mm", [](bool) {
        Trial trial = ball_trial();
        MeshItem second = trial.scene.meshes[0];
        second.id = 2, second.name = "second";
        second.mesh = make_sphere({-2, 1, 0}, 10, 1);
        trial.scene.meshes.push_back(second);
        return trial;
      });
  return cases;
}

}  // namespace simplexseg
