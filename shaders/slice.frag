#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Window and level: intensity low -> black, high -> white. NaN is outside the volume: nothing is drawn.
uniform sampler2D intensities;
uniform float low;
uniform float high;
uniform float darkest_shown;
in vec2 texture_position;
out vec4 colour;

void main() {
  float intensity = texture(intensities, texture_position).r;
  if (isnan(intensity)) discard;
  float grey = clamp((intensity - low) / max(high - low, 1e-30), 0.0, 1.0);
  if (grey < darkest_shown) discard;
  colour = vec4(vec3(grey), 1.0);
}
