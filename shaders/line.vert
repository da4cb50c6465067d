#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Each instance is a segment, drawn as a rectangle that extends half_width_px + 1 pixels beyond it on all sides.
uniform mat4 clip_from_world;
uniform vec2 viewport_px;
uniform float half_width_px;
layout(location = 0) in vec3 start_mm;
layout(location = 1) in vec3 end_mm;
flat out vec2 start_px;
flat out vec2 end_px;
out vec2 here_px;

void main() {
  vec4 a = clip_from_world * vec4(start_mm, 1.0);
  vec4 b = clip_from_world * vec4(end_mm, 1.0);
  start_px = (a.xy / a.w * 0.5 + 0.5) * viewport_px;
  end_px = (b.xy / b.w * 0.5 + 0.5) * viewport_px;
  vec2 along = end_px - start_px;
  float length_px = length(along);
  along = length_px > 1e-4 ? along / length_px : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float reach = half_width_px + 1.0;
  bool at_end = (gl_VertexID & 1) == 1;
  here_px = (at_end ? end_px + reach * along : start_px - reach * along) +
            ((gl_VertexID & 2) == 0 ? -reach : reach) * across;
  vec4 at = at_end ? b : a;
  // Moves the line slightly in front of the surface on which it lies.
  gl_Position = vec4((here_px / viewport_px * 2.0 - 1.0) * at.w, at.z - 2e-4 * at.w, at.w);
}
