#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Tints the slice in proportion to the foreground probability P, which is given on a box of cells. Texels below
// field_floor encode the distance to the object (src/forces/step_view.h); P is about 0 there.
uniform sampler3D field;
uniform mat4 index_from_world;
uniform float field_floor;  // smallest sampler value (0 to 1) that is a probability
uniform vec4 tint;
in vec3 position_mm;
out vec4 colour;

void main() {
  vec3 size = vec3(textureSize(field, 0));
  vec3 cell = (index_from_world * vec4(position_mm, 1.0)).xyz + 0.5;
  if (any(lessThan(cell, vec3(0.0))) || any(greaterThan(cell, size))) discard;
  float p = texture(field, cell / size).r;
  if (p < field_floor) discard;
  colour = vec4(tint.rgb, tint.a * p);
}
