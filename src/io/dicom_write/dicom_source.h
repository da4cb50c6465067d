// SPDX-License-Identifier: Apache-2.0
// Attributes of the segmented DICOM image that the file of a segmentation copies or refers to.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "core/segment_code.h"
#include "image/volume.h"
#include "io/dicom/dicom_item.h"

namespace simplexseg {

/// DICOM instance (file or frame) that contains a slice.
struct DicomInstance {
  std::string sop_class, sop_instance;
  int frame = 0;  ///< frame number from 1 in a multi-frame file, otherwise 0
  Eigen::Vector3d position_mm;
};

struct DicomSource {
  VolumeGeometry geometry;
  std::vector<DicomInstance> slices;  ///< one for each slice index k
  std::string study, series, frame_of_reference, modality;
  bool unicode = false;                   ///< the texts are UTF-8, so that new texts can be, too
  std::string lossy_ratio, lossy_method;  ///< lossy compression of the images; empty when lossless
  DicomItem context;                      ///< patient, study, frame of reference and character set of the image

  /// Returns a reference to a slice: SOP class UID, SOP instance UID and, for multi-frame files, frame number.
  DicomItem reference(std::size_t slice) const;
  /// Returns references to the files of the slices, without duplicates.
  std::vector<DicomItem> references() const;
};

/// Reads the headers of the volume at `path`; `volume` and `series` have the meaning of these arguments of
/// load_volume(). `target` is the file to be written, for messages. Throws Error when the volume is not a DICOM image
/// or is unreadable, or when the slices have no position, orientation or UIDs.
DicomSource read_dicom_source(const std::filesystem::path& path, const std::filesystem::path& target, int volume = 1,
                              const std::string& series = {});

/// Converts a name to a DICOM text (LO) on one line of at most `max_characters` characters, "unnamed" if empty. A
/// backslash becomes "/"; unless the source uses UTF-8, each non-ASCII character becomes "?".
std::string dicom_name(const std::string& name, const DicomSource& source, std::size_t max_characters = 64);

/// Converts names like dicom_name(), but distinct, in the same order: a text already in use gets the suffix "-2", "-3"
/// and so on within the limit. `max_characters`: at least 8.
std::vector<std::string> dicom_names(const std::vector<std::string>& names, const DicomSource& source,
                                     std::size_t max_characters = 64);

/// Adds the codes of a segment: the property category (0062,0003), and the property type, with its modifier, as the
/// sequence `type` (PS3.3 C.8.20.4 and C.8.8.8). Empty codes are those of tissue.
void add_segment_code(DicomItem& item, DicomTag type, const SegmentCode& code, const DicomSource& source);

/// Date (YYYYMMDD) and time (HHMMSS) in DICOM format.
struct DicomDateTime {
  std::string date, time;
};
/// Returns the current local date and time.
DicomDateTime dicom_now();

/// Adds the attributes common to all written objects: SOP class, new SOP instance and series UIDs, date, time and
/// equipment. `modality`: DICOM code, e.g. SEG.
void add_common_attributes(DicomItem& data, const std::string& sop_class, const std::string& modality,
                           const DicomDateTime& now);

}  // namespace simplexseg
