// SPDX-License-Identifier: Apache-2.0
#include "gui/drawing/cut_scope.h"

#include <GL/glew.h>

#include <algorithm>
#include <array>

#include "core/expect.h"
#include "gui/drawing/painters.h"
#include "gui/look/clip_planes.h"

namespace simplexseg {

CutScope::CutScope(const Program& program, CutEquations planes) : count_(static_cast<unsigned>(planes.size())) {
  SIMPLEXSEG_EXPECT(planes.size() <= kCutPlanes);
  // Zeros remove nothing. Drivers that ignore a disabled distance would otherwise cut with the planes of the last
  // scope.
  std::array<Eigen::Vector4f, kCutPlanes> all;
  all.fill(Eigen::Vector4f::Zero());
  std::copy(planes.begin(), planes.end(), all.begin());
  program.set("cut", all);
  for (unsigned plane = 0; plane < count_; ++plane) glEnable(GL_CLIP_DISTANCE0 + plane);
}

CutScope::~CutScope() {
  for (unsigned plane = 0; plane < count_; ++plane) glDisable(GL_CLIP_DISTANCE0 + plane);
}

}  // namespace simplexseg
