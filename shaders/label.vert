#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Each instance is a rectangle of the texture of text labels, in device pixels from the top left.
uniform vec2 viewport_px;
layout(location = 0) in vec4 rectangle_px;  // x, y, width, height

void main() {
  vec2 at = rectangle_px.xy + vec2(gl_VertexID & 1, gl_VertexID >> 1) * rectangle_px.zw;
  gl_Position = vec4(at.x / viewport_px.x * 2.0 - 1.0, 1.0 - at.y / viewport_px.y * 2.0, 0.0, 1.0);
}
