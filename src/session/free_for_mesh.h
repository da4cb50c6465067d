// SPDX-License-Identifier: Apache-2.0
// Names, labels and colours that no mesh of a scene has yet: those of the mesh that is to join it.
#pragma once
#include <algorithm>
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// The first of 1, 2, 3 ... that none of the meshes has, as `has(mesh, number)` says.
template <class Has>
int first_free(const Scene& scene, Has has) {
  int number = 1;
  while (std::any_of(scene.meshes.begin(), scene.meshes.end(), [&](const MeshItem& item) { return has(item, number); }))
    ++number;
  return number;
}

/// "mesh 1", "mesh 2" ...
std::string free_name(const Scene& scene);
int free_label(const Scene& scene);
/// The first colour of the palette that no mesh has; of more meshes than colours the one that is due.
Colour free_colour(const Scene& scene);

}  // namespace simplexseg
