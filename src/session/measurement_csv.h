// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <string>

#include "session/scene.h"

namespace simplexseg {

class Volume;

/// CSV table with a line for each measurement of a scene, then one for each segmentation: volume, intensities inside,
/// long and short axis (object_axes()). Columns are documented in docs/manual.md; a field without a value is empty.
/// `volume`: may be empty.
std::string measurement_csv(const Scene& scene, const Volume& volume);

}  // namespace simplexseg
