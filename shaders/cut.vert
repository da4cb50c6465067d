#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Counts the faces of a surface behind one cutting plane, for the stencil of its cut face.
uniform mat4 clip_from_world;
uniform vec4 cut[4];  // removes where dot(cut, position) > 0
layout(location = 0) in vec3 position_mm;
out float gl_ClipDistance[4];

void main() {
  for (int n = 0; n < 4; ++n) gl_ClipDistance[n] = -dot(cut[n], vec4(position_mm, 1.0));
  gl_Position = clip_from_world * vec4(position_mm, 1.0);
}
