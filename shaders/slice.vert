#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a textured parallelogram in the patient frame: corner + s * edge_u + t * edge_v.
uniform mat4 clip_from_world;
uniform vec3 corner;
uniform vec3 edge_u;
uniform vec3 edge_v;
out vec2 texture_position;

void main() {
  texture_position = vec2(gl_VertexID & 1, gl_VertexID >> 1);
  gl_Position = clip_from_world * vec4(corner + texture_position.x * edge_u + texture_position.y * edge_v, 1.0);
}
