#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a segment as a capsule (round ends), with a smooth edge of one pixel.
uniform vec4 line_colour;
uniform float half_width_px;
flat in vec2 start_px;
flat in vec2 end_px;
in vec2 here_px;
out vec4 colour;

void main() {
  vec2 along = end_px - start_px;
  float t = clamp(dot(here_px - start_px, along) / max(dot(along, along), 1e-8), 0.0, 1.0);
  float coverage = clamp(half_width_px + 0.5 - distance(here_px, start_px + t * along), 0.0, 1.0);
  if (coverage <= 0.0) discard;
  colour = vec4(line_colour.rgb, line_colour.a * coverage);
}
