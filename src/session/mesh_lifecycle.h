// SPDX-License-Identifier: Apache-2.0
// Life cycle of a mesh: it starts as the sphere of its seed and is refined level by level, whenever it has settled or
// used up the steps of a level, up to its finest level. Reasons: docs/adr/0006-coarse-to-fine.md.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Smallest voxel spacing in mm; 1 for an empty volume.
double voxel_mm(const Volume& volume);

/// Resets a mesh to the sphere of its seed, at its first level, or to the labels that it starts from. Discards its
/// profiles and solver state, and estimates its region model again.
void restart(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);
/// Prepares a mesh for the engine. Restarts one without a pose; adds missing state to one with a pose (previous
/// positions, shape reference, region model).
void complete(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);
/// Refines a mesh to the next level, with four times as many vertices. New vertices inherit the profiles of their
/// parent; the shape reference is computed from the refined mesh.
void refine_item(MeshItem& item);
/// Records the intensity profiles at the current pose as the reference. Throws Error without a volume.
void record_profiles(MeshItem& item, const Volume& volume);

/// Whether the evidence force of a mesh uses a field.
bool uses_field(const MeshItem& item, const Volume& volume);
/// Whether a mesh does not move because its field has not been solved yet.
bool waits_for_field(const MeshItem& item, const Volume& volume);
/// Parameters for the engine: those of the mesh, with weights 0 for a locked mesh and, while the mesh waits for its
/// field, weights 0 for all forces except attraction.
ForceParameters active_parameters(const MeshItem& item, const Volume& volume);

/// Progress of a mesh at its level.
enum class LevelState {
  Moving,         ///< neither settled nor out of steps, or still moving on the finest level
  Settled,        ///< settled on the finest level
  RefinementDue,  ///< settled or out of steps on a coarser level
};
/// State of a mesh after a step. `mean_move_mm`, `mean_edge_mm`: mean motion and mean edge length of the last step
/// (StepOutcome).
LevelState level_state(const MeshItem& item, const SimulationParameters& simulation, const Volume& volume,
                       float mean_move_mm, float mean_edge_mm);

}  // namespace simplexseg
