// SPDX-License-Identifier: Apache-2.0
// Life cycle of a mesh, which starts as the sphere of its seed. Whenever it has settled or has used up the steps of its
// level, it is refined, up to its finest level. Reasons: docs/adr/0006-coarse-to-fine.md.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Estimates the region model of a mesh from its present pose.
void update_region(MeshItem& item, const Volume& volume);
/// Smallest voxel spacing in mm; 1 for an empty volume.
double voxel_mm(const Volume& volume);

/// Resets a mesh to the sphere of its seed at its first level, or to the mesh of MeshItem::start. Discards its profiles
/// and solver state, and estimates its region model again. With MeshItem::model_profiles it gets those of its model.
void restart(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);
/// Prepares a mesh for the engine. Restarts a mesh without vertices. Otherwise adds missing state (previous positions,
/// mean edge length, shape reference, region model) and discards a field whose box exceeds the volume.
void complete(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);
/// Refines a mesh to the next level, with four times as many vertices and zero velocity. Each new vertex inherits the
/// profile of its parent; the shape reference is computed from the refined mesh.
void refine_item(MeshItem& item);
/// Records the intensity profiles at the current pose as the reference profiles. Throws Error without a volume.
void record_profiles(MeshItem& item, const Volume& volume);
/// Sets the reference profiles to the mean profiles of the model in the intensities of the volume, now and at each
/// restart. Throws Error without a volume, for a mesh that does not have the vertices of its model, refined or not, and
/// for parameters of the force with longer profiles.
void use_model_profiles(MeshItem& item, const Volume& volume);
/// Calls use_model_profiles() for a mesh with MeshItem::model_profiles, after a change of its vertices or of the
/// parameters of the force. Without profiles of the model for them, the mesh has none. Returns whether the profiles may
/// have changed.
bool renew_model_profiles(MeshItem& item, const Volume& volume);
/// Sets the parameters of the forces of a mesh. Returns as renew_model_profiles().
bool set_parameters(MeshItem& item, const ForceParameters& parameters, const Volume& volume);

/// Whether the evidence force of a mesh has a weight above 0 and uses a field; false without a volume.
bool uses_field(const MeshItem& item, const Volume& volume);
/// Whether a mesh uses a field that has not been solved yet or could not be solved. Only attraction then moves the
/// mesh.
bool waits_for_field(const MeshItem& item, const Volume& volume);
/// Parameters for the engine: those of the mesh, but with all weights 0 if it is locked, and with all weights except
/// that of attraction 0 while it waits for its field.
ForceParameters active_parameters(const MeshItem& item, const Volume& volume);

/// Progress of a mesh at its level.
enum class LevelState {
  Moving,         ///< not settled and not due for refinement
  Settled,        ///< settled on the finest level, or locked, asleep, or settled while it waits for its field or with a
                  ///< preliminary one, or without a field because its solution failed or was cancelled
  RefinementDue,  ///< settled on a coarser level, or the steps of that level are used up
};
/// State of a mesh after a step. `mean_move_mm`: mean motion in the last step; `mean_edge_mm`: mean edge length after
/// it (StepOutcome).
LevelState level_state(const MeshItem& item, const SimulationParameters& simulation, const Volume& volume,
                       float mean_move_mm, float mean_edge_mm);

}  // namespace simplexseg
