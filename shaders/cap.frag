#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a cut face in the colour of its surface, or the image in this colour. Texels of the image: as in slice.frag.
uniform sampler2D image;
uniform vec4 cap_colour;
uniform float image_share;  // 0: colour alone
in vec2 image_position;
out vec4 colour;

void main() {
  vec3 base = cap_colour.rgb;
  if (image_share > 0.0 && all(greaterThan(image_position, vec2(0.0))) && all(lessThan(image_position, vec2(1.0)))) {
    vec2 texel = texture(image, image_position).rg;
    if (texel.g > 0.5) {
      // Mid grey keeps the colour, dark voxels darken it and bright ones whiten it.
      float grey = texel.r / texel.g;
      vec3 tinted = grey < 0.5 ? base * (0.4 + 1.2 * grey) : mix(base, vec3(1.0), 1.1 * (grey - 0.5));
      base = mix(base, tinted, image_share);
    }
  }
  colour = vec4(base, cap_colour.a);
}
