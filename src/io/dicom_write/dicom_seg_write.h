// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_write/dicom_source.h"
#include "io/source/segment_names.h"

namespace simplexseg {

/// Encoding of a segmentation. Binary: a bit plane for each segment, which every reader of segmentations knows.
/// LabelMap: one plane whose pixels are the label values (Supplement 243, standard of 2024).
enum class SegmentEncoding { Binary, LabelMap };

/// Segment of a file that was written.
struct WrittenSegment {
  int label = 0;             ///< value of the voxels
  std::uint32_t number = 0;  ///< Segment Number (0062,0004)
  std::string tracking_id, tracking_uid;
};

/// File that was written, for objects that refer to it.
struct WrittenSegmentation {
  std::string sop_class, sop_instance, series;
  std::vector<WrittenSegment> segments;
  std::string note;  ///< message for the user when segment numbers differ from label values, otherwise empty
};

/// Writes integer labels on the grid of the image `source` as DICOM segmentation (PS3.3 A.51). There is a segment for
/// each of `names` and for each other label in the volume. Each gets its codes, or those of tissue, its name by
/// dicom_names(), and a new tracking UID. Binary: segments are numbered from 1 in the order of the label values, and
/// each has a frame for every slice in which it has voxels; slices without any voxel get a frame of the first segment,
/// so that readers obtain the whole grid. Label map: segments have the numbers of their labels, there is a frame for
/// each slice, of 8 bits up to label 255, and segment 0 describes the background. Throws Error when there is neither a
/// labelled voxel nor a name, when a label is below 1 or above 65535, when the grids differ, when there are more than
/// 65535 segments or 4 GiB of pixels, or when the file cannot be written.
WrittenSegmentation write_dicom_segmentation(const std::filesystem::path& path, const Volume& labels,
                                             const std::vector<SegmentName>& names, DicomSource source,
                                             SegmentEncoding encoding = SegmentEncoding::Binary);

}  // namespace simplexseg
