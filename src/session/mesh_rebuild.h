// SPDX-License-Identifier: Apache-2.0
// A mesh that cannot come to where its field says the object is (another topology, processes too thin to be entered, a
// surface that has folded) is made anew of the field's surface. docs/adr/0013-meshes-made-of-fields.md says why.
#pragma once
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// The voxels at which the mesh and its field disagree deeply: on them and on all six neighbours, so that no surface
/// that is off by a voxel counts. Needs a field.
int deep_disagreement(const MeshItem& item, const Volume& volume);
/// Makes the mesh of the surface of its field, with about as many vertices as it is to end with, at rest and on its
/// finest level. False, with nothing changed, where the field has no object.
bool rebuild_from_field(MeshItem& item, const SimulationParameters& simulation, const Volume& volume);

}  // namespace simplexseg
