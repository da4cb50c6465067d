// SPDX-License-Identifier: Apache-2.0
// The life of a mesh: it starts as the sphere of its seed, comes to rest or uses up its steps at a level, is refined,
// and so on to its finest level. docs/adr/0006-coarse-to-fine.md says why.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Edge of the smallest voxel side, mm; 1 for an empty volume.
double voxel_mm(const Volume& volume);

/// Puts a mesh back to the sphere of its seed, at its first level, or to the labels that it starts from, and forgets
/// all that it has learnt and recorded. Its region model is estimated anew.
void restart(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);
/// Makes a mesh ready for the engine: one without a pose is started, one with a pose gets what it lacks of the state
/// that belongs to it (positions of the step before, shape reference, region model).
void complete(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);
/// Refines a mesh to the next level: four vertices for each. New vertices take over their parents' profiles; the shape
/// reference is taken anew.
void refine_item(MeshItem& item);
/// Takes the intensity profiles under the present pose as the reference. Throws Error without a volume.
void record_profiles(MeshItem& item, const Volume& volume);

/// Whether a mesh takes its evidence from its field, where it has one.
bool takes_field(const MeshItem& item, const Volume& volume);
/// Whether a mesh stays as it is until the field that it takes its evidence from has been learned.
bool waits_for_field(const MeshItem& item, const Volume& volume);
/// What an engine is told of a mesh: its parameters, all weights but that of attraction 0 while it waits for its field,
/// and all of them 0 while it is locked.
ForceParameters parameters_in_use(const MeshItem& item, const Volume& volume);

/// How far a mesh has come at its level.
enum class LevelState {
  Moves,  ///< it has neither come to rest nor used up its steps, or moves still on its finest level
  Rests,  ///< on its finest level
  Due,    ///< for refinement
};
/// `mean_move_mm` and `mean_edge_mm`: of the mesh in and after the last step, as in StepOutcome.
LevelState level_state(const MeshItem& item, const SimulationParameters& simulation, const Volume& volume,
                       float mean_move_mm, float mean_edge_mm);

}  // namespace simplexseg
