// SPDX-License-Identifier: Apache-2.0
// Sleep of settled meshes: they are not stepped until a command or a new field acts on them. Reasons:
// docs/adr/0042-sleeping-meshes.md.
#pragma once
#include <cstdint>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Digest of all that acts on a mesh, except for its field and the image: its active forces, the simulation parameters,
/// its boundary points, and the geometry of the volume.
std::uint64_t input_digest(const MeshItem& item, const Scene& scene, const Volume& volume);

/// Wakes the meshes whose inputs have changed since the last call.
void wake_changed_meshes(Scene& scene, const Volume& volume);

/// For each mesh, 1 if it sleeps, else 0: the argument of Engine::set_asleep().
std::vector<char> sleeping_meshes(const Scene& scene);

}  // namespace simplexseg
