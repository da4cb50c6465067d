#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws a layer over a slice. Red: value times green; green: 1 within the layer, 0 outside. Colour maps in the order of
// ColourMap (session/layer.h), modes in that of LayerMode (gui/look/view_state.h).
uniform sampler2D slice;
uniform vec2 values;  // value of the first colour, and difference to that of the last one
uniform float colour_map;
uniform float opacity;
uniform float mode;
uniform float divider_px;  // swipe: left edge of the layer
uniform float square_px;   // checkerboard: side of a square
in vec2 texture_position;
out vec4 colour;

vec3 colour_of(float share) {
  if (colour_map < 0.5) return vec3(share);
  if (colour_map < 1.5) return vec3(1.0 - share);
  if (colour_map < 2.5) return clamp(vec3(8.0 / 3.0, 8.0 / 3.0, 4.0) * share - vec3(0.0, 1.0, 3.0), 0.0, 1.0);  // hot
  return colour_map < 3.5 ? vec3(0.0, share, 0.0) : vec3(share, 0.0, share);
}

void main() {
  if (mode > 1.5) {
    if (gl_FragCoord.x < divider_px) discard;
  } else if (mode > 0.5) {
    ivec2 square = ivec2(floor(gl_FragCoord.xy / square_px));
    if (((square.x + square.y) & 1) == 0) discard;
  }
  vec2 texel = texture(slice, texture_position).rg;
  if (texel.g < 0.5) discard;
  float share = clamp((texel.r / texel.g - values.x) / values.y, 0.0, 1.0);
  bool fades = mode < 0.5 && colour_map > 1.5;
  colour = vec4(colour_of(share), opacity * (fades ? min(1.0, 4.0 * share) : 1.0));
}
