#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a square of a cutting plane: corner + s * edge_u + t * edge_v, without the parts that other planes remove.
uniform mat4 clip_from_world;
uniform vec3 corner;
uniform vec3 edge_u;
uniform vec3 edge_v;
uniform vec4 cut[4];  // removes where dot(cut, position) > 0
uniform vec4 image_u;  // texture coordinates of the image are dot(image_u, position), dot(image_v, position)
uniform vec4 image_v;
out vec2 image_position;
out float gl_ClipDistance[4];

void main() {
  vec4 position_mm = vec4(corner + float(gl_VertexID & 1) * edge_u + float(gl_VertexID >> 1) * edge_v, 1.0);
  for (int n = 0; n < 4; ++n) gl_ClipDistance[n] = -dot(cut[n], position_mm);
  image_position = vec2(dot(image_u, position_mm), dot(image_v, position_mm));
  gl_Position = clip_from_world * position_mm;
}
