#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Each instance is the triangle between a segment of a contour and a corner of the view. A pixel lies inside the
// contour if an odd number of these triangles covers it. The fourth vertex of the strip repeats the third.
uniform mat4 clip_from_world;
layout(location = 0) in vec3 start_mm;
layout(location = 1) in vec3 end_mm;

void main() {
  gl_Position = gl_VertexID == 0 ? vec4(-1.0, -1.0, 0.0, 1.0)
                                 : clip_from_world * vec4(gl_VertexID == 1 ? start_mm : end_mm, 1.0);
}
