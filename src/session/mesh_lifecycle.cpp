// SPDX-License-Identifier: Apache-2.0
#include "session/mesh_lifecycle.h"

#include <algorithm>

#include "core/error.h"
#include "core/expect.h"
#include "forces/force_list.h"
#include "forces/profile_reference.h"
#include "image/volume.h"
#include "mesh/mesh_geometry.h"
#include "mesh/shape_reference.h"
#include "model/mean_profiles.h"
#include "model/start_shape.h"
#include "session/scene_checks.h"

namespace simplexseg {
namespace {

/// Margin of the background region around the bounding box of the mesh, in radii of the seed.
constexpr double kBackgroundRadii = 2;
/// Number of steps since something acted on a mesh from which on the tolerance of its motion grows.
constexpr float kPatientSteps = 1000;

RegionModel region_of(const MeshItem& item, const Volume& volume) {
  return estimate_region(volume, item.mesh, kBackgroundRadii * item.seed.radius_mm);
}

float edge_of(const SimplexMesh& mesh) { return mean_edge_mm(mesh.positions, mesh.neighbours); }

/// Largest mean motion of a settled mesh, mm per step. Vertices whose targets alternate between positions never stop,
/// so the tolerance grows with the steps since something acted on the mesh.
float rest_tolerance_mm(const MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  const float patience = std::max(1.0f, static_cast<float>(item.sleep.awake_steps) / kPatientSteps);
  return patience * static_cast<float>(simulation.rest_tolerance_voxels * voxel_mm(volume));
}

/// Sphere of the seed with the number of vertices of the first level.
SimplexMesh sphere_of(const MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  // A mesh finer than the voxels follows their noise, so the mean edge is at least `finest_edge` voxels.
  int level = sphere_level_for(static_cast<int>(simulation.start_vertices + 0.5f));
  SimplexMesh mesh;
  do mesh = make_sphere(item.seed.centre_mm, item.seed.radius_mm, level);
  while (level-- > 0 && measure(mesh).mean_edge_mm < simulation.finest_edge * voxel_mm(volume));
  return mesh;
}

}  // namespace

void update_region(MeshItem& item, const Volume& volume) { item.region = region_of(item, volume); }

double voxel_mm(const Volume& volume) { return volume.empty() ? 1.0 : volume.geometry().spacing_mm.minCoeff(); }

void restart(MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  const bool has_shape = item.model && !item.start_modes.empty();
  item.mesh = item.start ? *item.start->mesh
              : has_shape
                  ? shape_at_seed(*item.model->organ, item.seed.centre_mm, item.seed.radius_mm, item.start_modes)
                  : sphere_of(item, simulation, volume);
  item.previous = item.mesh.positions;
  item.edge_mm = edge_of(item.mesh);
  item.shape = shape_reference_of(item.mesh);
  item.profiles.clear();
  item.steps_at_level = 0;
  item.rebuilt = item.start.has_value() || has_shape, item.fit = {};
  item.solver = {}, item.sleep = {};
  item.region = region_of(item, volume);
  renew_model_profiles(item, volume);
}

bool renew_model_profiles(MeshItem& item, const Volume& volume) {
  if (!item.model_profiles || volume.empty()) return false;
  try {
    use_model_profiles(item, volume);
  } catch (const Error&) {
    item.profiles.clear();
  }
  return true;
}

bool set_parameters(MeshItem& item, const ForceParameters& parameters, const Volume& volume) {
  const bool same_samples = IntensityProfileForce::same_samples(item.parameters, parameters);
  item.parameters = parameters;
  return !same_samples && renew_model_profiles(item, volume);
}

void complete(MeshItem& item, const SimulationParameters& simulation, const Volume& volume) {
  if (item.mesh.positions.empty()) {
    restart(item, simulation, volume);
    return;
  }
  if (item.previous.size() != item.mesh.positions.size()) item.previous = item.mesh.positions;
  if (!(item.edge_mm > 0)) item.edge_mm = edge_of(item.mesh);
  if (item.shape.size() != item.mesh.positions.size()) item.shape = shape_reference_of(item.mesh);
  if (item.region.empty()) item.region = region_of(item, volume);
  // The parameters may have been edited outside the program, after the profiles were recorded.
  if (!IntensityProfileForce::has_reference(item.parameters,
                                            {item.mesh.vertex_count(), !item.shape.empty(), item.profiles.size()}))
    renew_model_profiles(item, volume);
  if (item.has_field() && !item.field->box.lies_in(cell_geometry(volume.geometry(), item.field->cell).size))
    item.field = nullptr, item.fit = {};
}

void refine_item(MeshItem& item) {
  SIMPLEXSEG_EXPECT(item.mesh.positions.empty() || item.profiles.size() % item.mesh.positions.size() == 0);
  const std::size_t stride = item.mesh.positions.empty() ? 0 : item.profiles.size() / item.mesh.positions.size();
  Refined refined = refine(item.mesh);
  std::vector<float> profiles;
  for (int parent : refined.parent)
    profiles.insert(profiles.end(), item.profiles.begin() + parent * stride,
                    item.profiles.begin() + (parent + 1) * stride);
  item.mesh = std::move(refined.mesh);
  item.previous = item.mesh.positions;
  item.profiles = std::move(profiles);
  item.edge_mm = edge_of(item.mesh);
  item.shape = shape_reference_of(item.mesh);
  item.steps_at_level = 0;
  item.solver = {}, item.sleep = {};
}

void record_profiles(MeshItem& item, const Volume& volume) {
  if (volume.empty()) throw Error("intensity profiles", "no image is open", "open one first");
  item.profiles = profile_reference_of(item.mesh, volume, item.parameters);
  item.model_profiles = false;
  item.sleep = {};
}

void use_model_profiles(MeshItem& item, const Volume& volume) {
  if (volume.empty()) throw Error("intensity profiles", "no image is open", "open one first");
  check_model_profiles(item);
  const OrganModel& organ = *item.model->organ;
  const std::optional<std::vector<int>> vertices = template_vertices(organ.shape.mean, item.mesh);
  if (!vertices)
    throw Error("the profiles of '" + item.name + "'", "its surface no longer has the vertices of its model",
                "reset it to the shape of the model first");
  const auto [half, step_mm] = profile_samples_of(item.parameters, volume);
  const std::vector<float> mean = mean_profiles(organ, volume, item.seed.centre_mm, half, step_mm, run_serially());
  const int length = 2 * half + 1;
  item.profiles.clear();
  item.profiles.reserve(vertices->size() * length);
  for (const int v : *vertices)
    item.profiles.insert(item.profiles.end(), mean.begin() + v * length, mean.begin() + (v + 1) * length);
  item.model_profiles = true;
  item.sleep = {};
}

bool uses_field(const MeshItem& item, const Volume& volume) {
  return !volume.empty() && item.parameters.weight(ForceId::Evidence) > 0 && EvidenceForce::from_field(item.parameters);
}

bool waits_for_field(const MeshItem& item, const Volume& volume) {
  return uses_field(item, volume) && !item.has_field();
}

ForceParameters active_parameters(const MeshItem& item, const Volume& volume) {
  ForceParameters parameters = item.parameters;
  if (item.locked)
    for (auto& force : parameters.values) force[0] = 0;
  if (waits_for_field(item, volume))
    for (int force = 0; force < kForceCount; ++force)
      if ((kPullingForces & bit(static_cast<ForceId>(force))) == 0) parameters.values[force][0] = 0;
  return parameters;
}

LevelState level_state(const MeshItem& item, const SimulationParameters& simulation, const Volume& volume,
                       float mean_move_mm, float mean_edge_mm) {
  if (item.locked || item.sleep.asleep) return LevelState::Settled;
  const bool settled = mean_move_mm < rest_tolerance_mm(item, simulation, volume);
  if (waits_for_field(item, volume))
    return settled || item.field || item.cancelled ? LevelState::Settled : LevelState::Moving;
  if (item.has_field() && item.field->is_preliminary() && uses_field(item, volume))
    return settled ? LevelState::Settled : LevelState::Moving;
  if (!settled && item.steps_at_level < static_cast<int>(simulation.steps_per_level + 0.5f)) return LevelState::Moving;
  if (!is_finest(item, simulation, voxel_mm(volume), mean_edge_mm)) return LevelState::RefinementDue;
  return settled ? LevelState::Settled : LevelState::Moving;
}

}  // namespace simplexseg
