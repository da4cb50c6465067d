// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>
#include <vector>

#include "core/colour.h"
#include "core/segment_code.h"

namespace simplexseg {

/// Name, colour and codes of a label value.
struct SegmentName {
  int value = 0;  ///< label value of the voxels
  std::string name;
  Colour colour{230, 160, 60};
  SegmentCode code{};  ///< empty: unknown
  bool operator==(const SegmentName&) const = default;
};

}  // namespace simplexseg
