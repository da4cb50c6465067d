#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Each instance is a handle: a disc with a rim, whose radius on the screen is given in pixels.
uniform mat4 clip_from_world;
uniform vec2 viewport_px;
layout(location = 0) in vec3 centre_mm;
layout(location = 1) in vec4 fill;
layout(location = 2) in vec4 rim;
layout(location = 3) in vec2 radius_px_and_glyph;
flat out vec4 fill_colour;
flat out vec4 rim_colour;
flat out float radius;
flat out float glyph;
out vec2 offset_px;

void main() {
  vec4 centre = clip_from_world * vec4(centre_mm, 1.0);
  vec2 corner = vec2((gl_VertexID & 1) * 2 - 1, (gl_VertexID & 2) - 1);
  offset_px = corner * (radius_px_and_glyph.x + 2.0);
  fill_colour = fill;
  rim_colour = rim;
  radius = radius_px_and_glyph.x;
  glyph = radius_px_and_glyph.y;
  gl_Position = centre + vec4(offset_px / viewport_px * 2.0 * centre.w, -2e-4 * centre.w, 0.0);
}
