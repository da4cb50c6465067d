#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Draws text labels from their texture, which has the size of the view and premultiplied alpha.
uniform sampler2D labels;
uniform vec2 viewport_px;
out vec4 colour;

void main() {
  colour = texelFetch(labels, ivec2(gl_FragCoord.x, viewport_px.y - gl_FragCoord.y), 0);
}
