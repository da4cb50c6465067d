// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>
#include <vector>

#include "io/dicom_write/dicom_source.h"
#include "session/scene.h"

namespace simplexseg {

/// Writes the meshes of a scene as DICOM RT structure set (PS3.3 A.19.3). Each mesh becomes a region of interest with
/// the name (dicom_names()), colour and codes of the mesh. `codes`: one for each mesh; empty ones are those of tissue.
/// The contours of the region are the closed polygons in which the mesh intersects the slices of the image `source`,
/// rounded to 1e-4 mm or, for voxels below 0.1 mm, to less than a thousandth of a voxel. Holes are connected to the
/// outer contour by keyholes. Meshes can overlap. Throws Error when the scene has no mesh or the file cannot be
/// written.
void write_rtstruct(const std::filesystem::path& path, const Scene& scene, const std::vector<SegmentCode>& codes,
                    DicomSource source);

}  // namespace simplexseg
