#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Window and level are applied already. Red: grey, 0 outside the volume; green: 1 inside. Their quotient is the grey
// without the outside that the filter mixes in at the border.
uniform sampler2D slice;
layout(binding = 1) uniform sampler2D means;  // the same with its coarser levels
uniform float darkest_shown;
uniform float around;  // level of detail at which a texel is the mean of some voxels
in vec2 texture_position;
out vec4 colour;

void main() {
  vec2 texel = texture(slice, texture_position).rg;
  if (texel.g < 0.5) discard;
  float grey = texel.r / texel.g;
  if (darkest_shown > 0.0) {
    // What is dark in the dark is left open. A dark voxel in the object, or a bright one in the air about it, does not
    // count: they would stipple the slice.
    float mean = textureLod(means, texture_position, around).r;
    if (mean < darkest_shown || (grey < darkest_shown && mean < 3.0 * darkest_shown)) discard;
  }
  colour = vec4(vec3(grey), 1.0);
}
