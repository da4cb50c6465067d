// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <QString>
#include <array>
#include <map>
#include <vector>

#include "session/scene.h"

namespace simplexseg {

/// Values (mm) of the vertices by which the 3D view colours the meshes.
struct SurfaceValues {
  QString title;                                 ///< such as "distance to the reference"
  float most_mm = 1;                             ///< upper end of the colour scale; the lower end is 0
  std::map<ItemId, std::vector<float>> of_mesh;  ///< one value for each vertex of the mesh when it was checked
};

/// Colour of t (0..1) on the scale viridis (Smith and van der Walt 2015): dark blue to yellow, distinguishable
/// with any colour vision. mesh.frag contains the same function.
inline std::array<float, 3> scale_colour(float t) {
  // Polynomial fit of degree 6 by M. Zucker, also used in shaders.
  constexpr float kTerms[7][3] = {{0.2777273f, 0.0054073f, 0.3340998f},   {0.1050930f, 1.4046135f, 1.3845902f},
                                  {-0.3308618f, 0.2148476f, 0.0950952f},  {-4.6342305f, -5.7991010f, -19.3324410f},
                                  {6.2282699f, 14.1799334f, 56.6905526f}, {4.7763850f, -13.7451454f, -65.3530326f},
                                  {-5.4354558f, 4.6458526f, 26.3124352f}};
  std::array<float, 3> colour{};
  for (int term = 6; term >= 0; --term)
    for (int c = 0; c < 3; ++c)
      colour[static_cast<std::size_t>(c)] = colour[static_cast<std::size_t>(c)] * t + kTerms[term][c];
  return colour;
}

}  // namespace simplexseg
