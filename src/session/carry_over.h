// SPDX-License-Identifier: Apache-2.0
// Carries the segmentations of one study over to the next study of the patient (docs/follow-up.md).
#pragma once
#include <string>
#include <vector>

#include "image/transform.h"
#include "session/scene.h"

namespace simplexseg {

class Volume;

/// Marks that are carried over.
enum class CarriedMarks : std::uint8_t {
  Agreeing,  ///< those at which the images agree
  All,       ///< all that lie in the new image
  None
};

struct CarrySettings {
  /// Expected error of the carried surfaces (standard deviation), mm: how far the new object may differ from them
  /// (MeshStart::error_mm). 0: they are exactly the carried surfaces with the corrections of their marks.
  double error_mm = 3;
  CarriedMarks marks = CarriedMarks::Agreeing;
};

/// Part of a scene that was not carried over.
struct DroppedItem {
  std::string mesh;  ///< name of its segmentation
  std::string what;  ///< for example "outside mark 2"
  std::string why;
};

struct CarriedScene {
  Scene scene;  ///< scene of the new image; its volume_path is empty, and so are the paths of the starts
  std::vector<DroppedItem> dropped;
  int kept_marks = 0;
};

/// Scene of the study `next`, from the scene of the study `earlier`. `transform` maps points of `earlier` to points of
/// `next`. Each mesh starts from its mapped surface, which is the prior of its field; a locked mesh stays exactly that
/// surface. Names, colours, codes, labels, locks, visibility, and parameters stay; references, models, measurements,
/// layers and recorded profiles belong to the earlier image and are omitted. A range of intensities is dropped if the
/// values of the images differ. A mark agrees if, within `error_mm` or a voxel of its place, the new image has a value
/// as typical of the object as at the mark in the earlier image, or, for a boundary mark, an edge in the same
/// direction. Throws Error for an empty image, a scene without settled meshes, an error out of range, and if no mesh
/// lies in the new image.
CarriedScene carry_over(const Scene& scene, const Volume& earlier, const Volume& next, const Transform& transform,
                        const CarrySettings& settings);

}  // namespace simplexseg
