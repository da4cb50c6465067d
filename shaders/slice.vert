#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a textured parallelogram in the patient frame: corner + s * edge_u + t * edge_v.
uniform mat4 clip_from_world;
uniform vec3 corner;
uniform vec3 edge_u;
uniform vec3 edge_v;
uniform vec4 cut[4];  // removes where dot(cut, position) > 0
out vec2 texture_position;
out float gl_ClipDistance[4];

void main() {
  texture_position = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  vec4 position_mm = vec4(corner + texture_position.x * edge_u + texture_position.y * edge_v, 1.0);
  for (int n = 0; n < 4; ++n) gl_ClipDistance[n] = -dot(cut[n], position_mm);
  gl_Position = clip_from_world * position_mm;
}
