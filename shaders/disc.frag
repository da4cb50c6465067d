#version 450 core
// SPDX-License-Identifier: Apache-2.0
flat in vec4 fill_colour;
flat in vec4 rim_colour;
flat in float radius;
in vec2 offset_px;
out vec4 colour;

void main() {
  float distance_px = length(offset_px);
  float coverage = clamp(radius + 0.5 - distance_px, 0.0, 1.0);
  if (coverage <= 0.0) discard;
  float in_rim = clamp(distance_px - (0.7 * radius - 0.5), 0.0, 1.0);
  colour = mix(fill_colour, rim_colour, in_rim);
  colour.a *= coverage;
}
