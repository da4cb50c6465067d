#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Window and level are applied already. Red: grey, 0 outside the volume; green: 1 inside. Their quotient is the grey
// without the outside that the filter mixes in at the border.
uniform sampler2D slice;
uniform float darkest_shown;
in vec2 texture_position;
out vec4 colour;

void main() {
  vec2 texel = texture(slice, texture_position).rg;
  if (texel.g < 0.5) discard;
  float grey = texel.r / texel.g;
  if (grey < darkest_shown) discard;
  colour = vec4(vec3(grey), 1.0);
}
