// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <filesystem>

#include "io/dicom_source.h"
#include "session/scene.h"

namespace simplexseg {

/// Writes the contours of a scene's meshes as a DICOM RT structure set (PS3.3 A.19.3): a region of interest for each
/// mesh, with its name and colour, and on each slice of the image `source` the closed polygons in which the mesh meets
/// the slice's plane, to 1e-4 mm; holes are joined to what is around them by a cut of no width. Meshes may overlap.
/// Throws Error when the scene has no mesh or the file cannot be written.
void write_rtstruct(const std::filesystem::path& path, const Scene& scene, DicomSource source);

}  // namespace simplexseg
