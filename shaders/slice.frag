#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a slice to which window and level are already applied. Red: grey value, 0 outside the volume. Green: 1 inside,
// 0 outside. Dividing red by green removes the outside texels that filtering mixes in at the border.
uniform sampler2D slice;
layout(binding = 1) uniform sampler2D means;  // texture of the slice with mipmaps
uniform float darkest_shown;
uniform float mean_level;  // level of detail at which a texel is the mean over a few voxels
uniform vec2 tinted;  // grey values from x to y are tinted; none if x > y
uniform vec4 tint;
in vec2 texture_position;
out vec4 colour;

void main() {
  vec2 texel = texture(slice, texture_position).rg;
  if (texel.g < 0.5) discard;
  float grey = texel.r / texel.g;
  if (darkest_shown > 0.0) {
    // Dark voxels in a dark neighbourhood are transparent. Single dark voxels in the object and single bright ones in
    // the surrounding air are ignored, since they would stipple the slice.
    float mean = textureLod(means, texture_position, mean_level).r;
    if (mean < darkest_shown || (grey < darkest_shown && mean < 3.0 * darkest_shown)) discard;
  }
  bool is_tinted = tinted.x <= grey && grey <= tinted.y;
  colour = vec4(is_tinted ? mix(vec3(grey), tint.rgb, tint.a) : vec3(grey), 1.0);
}
