#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Cuts a triangle with the plane of the slice; the segment is widened as in line.vert, and line.frag draws it.
layout(triangles) in;
layout(triangle_strip, max_vertices = 4) out;
uniform mat4 clip_from_world;
uniform vec2 viewport_px;
uniform float half_width_px;
in vec3 corner_mm[];
in float height_mm[];
flat out vec2 start_px;
flat out vec2 end_px;
out vec2 here_px;

vec2 crossing_px(int a, int b) {
  float t = height_mm[a] / (height_mm[a] - height_mm[b]);
  vec4 clip = clip_from_world * vec4(mix(corner_mm[a], corner_mm[b], t), 1.0);
  return (clip.xy / clip.w * 0.5 + 0.5) * viewport_px;
}

void main() {
  // A corner on the plane counts as above it, so a triangle has either no crossing edge or two.
  bool above0 = height_mm[0] >= 0.0, above1 = height_mm[1] >= 0.0, above2 = height_mm[2] >= 0.0;
  if (above0 == above1 && above1 == above2) return;
  int alone = above0 == above1 ? 2 : above0 == above2 ? 1 : 0;
  vec2 a = crossing_px(alone, (alone + 1) % 3), b = crossing_px(alone, (alone + 2) % 3);
  vec2 along = b - a;
  float length_px = length(along);
  along = length_px > 1e-4 ? along / length_px : vec2(1.0, 0.0);
  vec2 across = vec2(-along.y, along.x);
  float reach = half_width_px + 1.0;
  for (int corner = 0; corner < 4; ++corner) {
    start_px = a;
    end_px = b;
    here_px = ((corner & 1) == 1 ? b + reach * along : a - reach * along) +
              ((corner & 2) == 0 ? -reach : reach) * across;
    gl_Position = vec4(here_px / viewport_px * 2.0 - 1.0, 0.0, 1.0);
    EmitVertex();
  }
  EndPrimitive();
}
