// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <optional>

#include "image/object_axes.h"
#include "image/surface_fit.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Measures of the object of a mesh in tables, reports and documents.
struct ObjectMeasures {
  double volume_mm3 = 0;                   ///< inside the surface
  std::optional<Intensities> intensities;  ///< of the voxels of the object, with its paint; nullopt: no finite voxel
  std::optional<ObjectAxes> axes;          ///< nullopt: no slice of the volume cuts the mesh
};

/// Measures the object of a mesh of a scene. `volume`: may be empty; then only the volume is measured.
ObjectMeasures measure_object(const MeshItem& item, const Scene& scene, const Volume& volume);

}  // namespace simplexseg
