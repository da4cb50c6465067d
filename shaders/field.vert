#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws the parallelogram of a slice in the patient frame: corner + s * edge_u + t * edge_v.
uniform mat4 clip_from_world;
uniform vec3 corner;
uniform vec3 edge_u;
uniform vec3 edge_v;
out vec3 position_mm;

void main() {
  position_mm = corner + float(gl_VertexID & 1) * edge_u + float(gl_VertexID >> 1) * edge_v;
  gl_Position = clip_from_world * vec4(position_mm, 1.0);
}
