// SPDX-License-Identifier: Apache-2.0
// The DICOM image that a segmentation was made on: what the segmentation's file takes over from it and refers to.
#pragma once
#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

#include "image/volume.h"
#include "io/dicom_item.h"

namespace simplexseg {

/// Where a slice of the volume comes from.
struct DicomInstance {
  std::string sop_class, sop_instance;
  int frame = 0;  ///< of a file with several, from 1; else 0
  Eigen::Vector3d position_mm;
};

struct DicomSource {
  VolumeGeometry geometry;
  std::vector<DicomInstance> slices;  ///< one for each k
  std::string study, series, frame_of_reference;
  bool unicode = false;                   ///< texts may be UTF-8, since those taken over are that, or ASCII
  std::string lossy_ratio, lossy_method;  ///< of the images' compression; empty where nothing was lost
  DicomItem context;                      ///< patient, study, frame of reference and coding of texts, as in the image

  /// Class and instance of one slice, and its frame where the file has several, as references have them.
  DicomItem reference(std::size_t slice) const;
  /// The files that the slices come from, each once.
  std::vector<DicomItem> references() const;
};

/// Reads the headers again of the volume at `path`. `target` names the file to be written in messages. Throws Error
/// when the volume is no DICOM image, does not say where its slices lie or what names them, or cannot be read any more.
/// `series`: as load_volume() takes it.
DicomSource read_dicom_source(const std::filesystem::path& path, const std::filesystem::path& target, int volume = 1,
                              const std::string& series = {});

/// A name as DICOM keeps it (LO): one line of `most` characters at most, without backslash, ASCII where the source's
/// coding is another than UTF-8.
std::string dicom_name(const std::string& name, const DicomSource& source, std::size_t most = 64);

/// Now, as DICOM keeps dates and times.
struct DicomMoment {
  std::string date, time;
};
DicomMoment dicom_now();

/// What files of segmentations have in common: SOP class, new series, date, equipment. `modality`: SEG, RTSTRUCT.
void describe_object(DicomItem& data, const std::string& sop_class, const std::string& modality,
                     const DicomMoment& now);

}  // namespace simplexseg
