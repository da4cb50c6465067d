// SPDX-License-Identifier: Apache-2.0
// Files of spatial transforms, as ITK, ANTs, 3D Slicer and elastix write them. All map points of the fixed image to the
// moving image, mm in LPS.
#pragma once
#include <filesystem>

#include "image/transform.h"

namespace simplexseg {

/// Reads a transform: ITK's text format (.tfm, .txt) and MATLAB format (.mat, of ANTs), or a displacement field in
/// NIfTI
/// (.nii, .nii.gz), and ITK's HDF5 format (.h5, of ANTs and Slicer), which simplexseg-register reads. Throws Error for
/// another extension, a damaged file, and a kind of transform that is not supported.
Transform read_transform(const std::filesystem::path& path);

/// Writes an affine transform in ITK's text format as an AffineTransform; each number is read as exactly the same one.
/// Throws Error for an extension other than .tfm and .txt, a transform with a displacement field, or a failed write.
void write_transform(const std::filesystem::path& path, const Transform& transform);

/// Reads a displacement field: three components of a voxel along the fifth dimension, in LPS (intent 1007, as ANTs
/// writes), or in RAS (intent 1006, as NIfTI defines). Throws Error for other volumes, for vectors that are not finite,
/// and the errors of open_nifti().
DisplacementField read_field(const std::filesystem::path& path);

/// Writes a displacement field as ANTs does: NIfTI with intent 1007 and vectors in LPS. Throws Error for an extension
/// other than .nii and .nii.gz, or a failed write.
void write_field(const std::filesystem::path& path, const DisplacementField& field);

/// Throws Error if write_transform() does not support the extension.
void require_transform_name(const std::filesystem::path& path);
/// Throws Error if write_field() does not support the extension.
void require_field_name(const std::filesystem::path& path);

}  // namespace simplexseg
