#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Enlarges an image of the largest values and their depths (volume.frag, mode 2). A value contributes where its place
// lies between near_depth and far_depth. The depth of a place is that of its own pixel: a place hidden there does not
// count, or a cut face that is not parallel to the screen would let places behind it through.
layout(binding = 0) uniform sampler2D maxima;
layout(binding = 1) uniform sampler2D far_depth;
layout(binding = 2) uniform sampler2D near_depth;
uniform float begins_at_depth;  // 1: the places begin at near_depth
uniform vec2 viewport_px;
uniform float low;
uniform float high;
uniform float inverted;
out vec4 colour;

void main() {
  vec2 screen = gl_FragCoord.xy / viewport_px;
  float end = texture(far_depth, screen).r;
  float begin = begins_at_depth > 0.5 ? texture(near_depth, screen).r : -1.0;
  ivec2 size = textureSize(maxima, 0);
  vec2 at = screen * vec2(size) - 0.5;
  ivec2 corner = ivec2(floor(at));
  vec2 part = at - vec2(corner);
  float bright = 0.0, counted = 0.0;
  for (int n = 0; n < 4; ++n) {
    ivec2 offset = ivec2(n & 1, n >> 1);
    ivec2 place = clamp(corner + offset, ivec2(0), size - 1);
    vec2 texel = texelFetch(maxima, place, 0).rg;
    if (texel.r >= 0.0 && texel.g > texture(far_depth, (vec2(place) + 0.5) / vec2(size)).r) continue;
    vec2 weights = mix(1.0 - part, part, vec2(offset));
    float weight = weights.x * weights.y;
    counted += weight;
    if (texel.r < 0.0 || texel.g > end || texel.g < begin) continue;
    bright += weight * clamp((texel.r - low) / (high - low), 0.0, 1.0);
  }
  if (bright <= 0.0) discard;
  bright /= counted;
  colour = vec4(vec3(inverted > 0.5 ? 1.0 - bright : bright), bright);
}
