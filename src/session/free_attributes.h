// SPDX-License-Identifier: Apache-2.0
// Unused names, labels and colours for a new mesh of a scene.
#pragma once
#include <algorithm>
#include <span>
#include <string>

#include "session/scene.h"

namespace simplexseg {

/// Smallest of the numbers 1, 2, 3 ... for which `has(mesh, number)` is false for every mesh.
template <class Has>
int first_free(const Scene& scene, Has has) {
  int number = 1;
  while (std::any_of(scene.meshes.begin(), scene.meshes.end(), [&](const MeshItem& item) { return has(item, number); }))
    ++number;
  return number;
}

/// First unused name of "mesh 1", "mesh 2" ...
std::string free_name(const Scene& scene);
/// Whether the name is one of "mesh 1", "mesh 2" ...
bool is_default_name(const std::string& name);
/// First unused name of "ruler 1", "ruler 2" ..., or with another kind.
std::string free_name(const Scene& scene, MeasurementKind kind);
/// Smallest label, from 1, that neither a mesh nor a name of the scene (LabelNumbers) has.
int free_label(const Scene& scene);
/// Label of a name in the scene (LabelNumbers); 0 if the name has none, or a mesh other than `mesh` has this label.
int label_of_name(const Scene& scene, const std::string& name, ItemId mesh);
/// Sets the labels of names. A mesh with one of these names gets its label; other meshes with a label of these names
/// get an unused one.
void set_labels(Scene& scene, LabelNumbers labels);
/// First of the colours of the palette that occur least often in `used`.
Colour free_colour(std::span<const Colour> used);
/// free_colour() of the colours of all meshes.
Colour free_colour(const Scene& scene);

}  // namespace simplexseg
