// SPDX-License-Identifier: Apache-2.0
// Stability cases: weights far beyond the sliders, of single forces and of pairs.
#include <cmath>

#include "forces/profile_reference.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "study/trials.h"

namespace simplexseg {
namespace {

const Eigen::Vector3d kPoint{23, 2, 1};  ///< position of an attraction point outside the ball, mm

/// Trial that starts near the fixed point of a single force, with recorded profiles and shape reference.
Trial trial_for(const std::string& force, float weight) {
  ForceParameters forces = forces_with({{force.c_str(), "weight", weight}});
  const SimplexMesh sphere = make_sphere({0, 0, 0}, kBallRadius, 2);
  SimplexMesh start = make_ellipsoid({0.7, 0.4, -0.5}, {17.8, 19.1, 20.4}, 2);
  if (force == "smoothing" || force == "shape_memory") start = add_noise(start, 0.1);
  if (force == "shape_memory") set_value(forces, {"shape_memory", "scaling", 0});
  Trial trial = trial_of(start, ball_volume(), forces);
  MeshItem& item = trial.scene.meshes[0];
  item.profiles = profile_reference_of(sphere, ball_volume(), forces);
  trial.error = radial_error(kBallRadius);
  trial.tolerance = 1.5;
  if (force == "smoothing") {
    set_value(trial.scene.meshes[0].parameters, {"smoothing", "curvature", 1});
    trial.error = volume_error(start), trial.tolerance = 0.1;
  } else if (force == "shape_memory") {
    item.shape = shape_reference_of(sphere);
    trial.tolerance = 0.05;
    trial.error = [shape = item.shape](const Scene& end) {
      const SimplexMesh& mesh = end.meshes[0].mesh;
      double sum = 0;
      for (int i = 0; i < mesh.vertex_count(); ++i) sum += std::abs(vertex_geometry(mesh, i).elevation_mm - shape[i].z);
      return sum / mesh.vertex_count() / measure(mesh).mean_edge_mm;
    };
  } else if (force == "gradient") {
    trial.folds = true;
  } else if (force == "attraction") {
    add_point(trial, kPoint);
    trial.error = distance_to(kPoint);
    trial.tolerance = 0.1;
  }
  trial.at_engine = true;
  trial.steps = 600;
  return trial;
}

std::string expected_end(const std::string& force) {
  if (force == "smoothing") return "the start's volume within 10%";
  if (force == "shape_memory") return "the reference's elevations within 5% of an edge";
  if (force == "attraction") return "a vertex on the point within 0.1 mm";
  if (force == "gradient")
    return "the ball's surface within 1.5 mm, with folds that are reported: no vertex knows of its neighbours";
  return "the ball's surface within 1.5 mm";
}

/// Case with two forces of the given weights.
StabilityCase two_force_case(const char* name, const char* strong, float strong_weight, const char* weak,
                             float weak_weight) {
  return {name,
          std::string(strong) + " at " + (strong_weight > 1 ? "1e6" : "1") + ", " + weak + " at " +
              (weak_weight < 1 ? "1e-6" : "1"),
          CaseOutcome::Bounded,
          CaseOutcome::Bounded,
          "the bound is the sum over forces, whatever their ratio",
          [=](bool) {
            Trial trial = trial_for(strong, strong_weight);
            set_value(trial.scene.meshes[0].parameters, {weak, "weight", weak_weight});
            if (std::string(weak) == "attraction") add_point(trial, kPoint);
            trial.folds = std::string(strong) == "attraction";
            return trial;
          }};
}

}  // namespace

std::vector<StabilityCase> force_cases() {
  std::vector<StabilityCase> cases;
  for (const ForceInfo& force : force_list()) {
    const std::string name = force.name;
    cases.push_back({name + "_1e-6", "weight 1e-6, no other force", CaseOutcome::Bounded, CaseOutcome::Bounded,
                     "a force so weak moves nothing by much, or its scaled step leads to its end",
                     [name](bool) { return trial_for(name, 1e-6f); }});
    cases.push_back({name + "_1e6", "weight 1e6, no other force", CaseOutcome::Converges, CaseOutcome::Converges,
                     "the timestep follows the weight; to " + expected_end(name),
                     [name](bool) { return trial_for(name, 1e6f); }});
  }
  for (const float weight : {1e-6f, 1e6f})
    cases.push_back({weight > 1 ? "field_1e6" : "field_1e-6",
                     std::string("evidence from a field, weight ") + (weight > 1 ? "1e6" : "1e-6") +
                         ", smoothing at 1, a point that is moved once",
                     CaseOutcome::Bounded, CaseOutcome::Bounded,
                     "learned again in between; the bound does not ask where evidence comes from", [weight](bool) {
                       Trial trial = trial_for("evidence", weight);
                       ForceParameters& forces = trial.scene.meshes[0].parameters;
                       set_value(forces, {"evidence", "source", 0});
                       set_value(forces, {"smoothing", "weight", 1});
                       set_value(forces, {"attraction", "weight", 2});
                       add_point(trial, kPoint);
                       // A point at this distance folds its patch, which is reported. Without other constraints,
                       // smoothing shrinks the mesh to a thread, whose volume may have either sign by rounding.
                       trial.folds = trial.inverted = true;
                       trial.chunk = 10;
                       trial.between = [](Session& session, int n) {
                         if (n == 5) session.apply(MovePoint{session.scene().points[0].id, 1.1 * kPoint, false});
                       };
                       return trial;
                     }});
  cases.push_back(two_force_case("smoothing_1e6_region_1e-6", "smoothing", 1e6f, "evidence", 1e-6f));
  cases.push_back(two_force_case("region_1e6_smoothing_1e-6", "evidence", 1e6f, "smoothing", 1e-6f));
  cases.push_back(two_force_case("shape_memory_1e6_gradient_1e-6", "shape_memory", 1e6f, "gradient", 1e-6f));
  cases.push_back(two_force_case("attraction_1e6_smoothing_1", "attraction", 1e6f, "smoothing", 1));
  cases.push_back(two_force_case("profile_1e6_attraction_1", "intensity_profile", 1e6f, "attraction", 1));
  for (const float weight : {1e-6f, 1e6f})
    cases.push_back({weight > 1 ? "all_forces_1e6" : "all_forces_1e-6",
                     std::string("all six weights at ") + (weight > 1 ? "1e6" : "1e-6"), CaseOutcome::Bounded,
                     CaseOutcome::Bounded, "a common factor of all weights is a factor of the timestep",
                     [weight](bool) {
                       Trial trial = trial_for("gradient", weight);
                       for (const ForceInfo& force : force_list())
                         set_value(trial.scene.meshes[0].parameters, {force.name, "weight", weight});
                       add_point(trial, kPoint);
                       trial.folds = true;
                       return trial;
                     }});
  return cases;
}

}  // namespace simplexseg
