// SPDX-License-Identifier: Apache-2.0
#include "session/object_measures.h"

#include "mesh/mesh_geometry.h"
#include "session/paint.h"

namespace simplexseg {

ObjectMeasures measure_object(const MeshItem& item, const Scene& scene, const Volume& volume) {
  ObjectMeasures measures;
  measures.volume_mm3 = measure(item.mesh).volume_mm3;
  if (volume.empty()) return measures;
  measures.intensities = intensities_in(volume, object_mask(item.mesh, paint_of(scene, item.id), volume.geometry()));
  measures.axes = object_axes(item.mesh, volume.geometry());
  return measures;
}

}  // namespace simplexseg
