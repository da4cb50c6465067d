#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a disc with a rim and a dark edge of one pixel. On a disc with a white plus or minus sign the rim is narrower.
flat in vec4 fill_colour;
flat in vec4 rim_colour;
flat in float radius;
flat in float glyph;  // sign on the disc: 0 none, 1 plus, 2 minus
in vec2 offset_px;
out vec4 colour;

float bar(vec2 at, float length_px, float half_width_px) {
  vec2 beyond = abs(at) - vec2(length_px, half_width_px);
  return clamp(0.5 - max(beyond.x, beyond.y), 0.0, 1.0);
}

void main() {
  float distance_px = length(offset_px);
  float coverage = clamp(radius + 1.5 - distance_px, 0.0, 1.0);
  if (coverage <= 0.0) discard;
  float rim_from = glyph > 0.5 ? 0.8 * radius : 0.7 * radius;
  colour = mix(fill_colour, rim_colour, clamp(distance_px - (rim_from - 0.5), 0.0, 1.0));
  if (glyph > 0.5) {
    float mark = bar(offset_px, 0.56 * radius, 0.15 * radius);
    if (glyph < 1.5) mark = max(mark, bar(offset_px.yx, 0.56 * radius, 0.15 * radius));
    colour.rgb = mix(colour.rgb, vec3(1.0), mark);
  }
  colour.rgb = mix(colour.rgb, vec3(0.04), clamp(distance_px - (radius - 0.5), 0.0, 1.0));
  colour.a *= coverage;
}
