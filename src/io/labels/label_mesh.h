// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "image/mask.h"
#include "io/source/segment_names.h"
#include "mesh/simplex_mesh.h"

namespace simplexseg {

/// Voxels of a label volume from which a mesh is made.
struct LabelChoice {
  std::optional<double> label{};      ///< nullopt: all voxels that are not 0
  int part = 0;                       ///< connected component, numbered by size from 1, the largest; 0: all
  std::string name{};                 ///< name of the label in the file; if not empty, it replaces `label` (label_of())
  std::optional<double> threshold{};  ///< lower limit of labelled values in a volume with fractions; nullopt: refused
};

/// Converts the voxels of a floating-point volume to labels. If all are whole within 1e-3 (or 1e-6 of the value, for
/// labels beyond the digits of float), rounds them, with a warning if one changes. If a voxel is a fraction, labels the
/// voxels from the threshold of `choice` with its label (1 if it has none), all others with 0. Adds a warning if the
/// threshold would change a volume of whole numbers, to which it is not applied. NaN counts as whole. `name`: name of
/// the volume in messages. Throws Error if a voxel is a fraction or infinite and there is no threshold, or none reaches
/// it.
void make_whole_labels(Volume& labels, const LabelChoice& choice, const std::string& name,
                       std::vector<std::string>& warnings);

/// Label in a volume, with its size.
struct LabelCount {
  double value = 0;
  std::string name;  ///< name in the file; empty if it has none
  std::optional<Colour> colour;
  SegmentCode code{};  ///< codes in the file; empty if it has none
  std::size_t voxels = 0;
  double millilitres = 0;
};
/// Labels other than 0 in a volume, sorted by value; only the `max_labels` largest ones if there are more. `names`:
/// names, colours and codes of labels. Throws Error for more than 65535 labels.
std::vector<LabelCount> count_labels(const Volume& labels, const std::vector<SegmentName>& names,
                                     std::size_t max_labels = 1000);

/// Voxels of a chosen label.
struct ChosenLabel {
  Mask mask;
  std::vector<std::size_t> parts;  ///< number of voxels in each connected component, the largest first
};

/// Mask of the chosen label and part; ignores LabelChoice::name. `name`: name of the volume in messages. Throws Error
/// if the label or the part does not exist, with a list of the labels or the number of parts.
ChosenLabel choose_label(const Volume& labels, const LabelChoice& choice, const std::string& name);

}  // namespace simplexseg
