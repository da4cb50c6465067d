#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Shades a surface by a light beside the camera, a weak light from below and a small highlight (Blinn-Phong).
uniform vec4 mesh_colour;
uniform float most_mm;  // upper end of the colour scale; 0: draws in mesh_colour
in vec3 eye_position;
in vec3 eye_normal;
in float value;  // value shown in colour, mm; negative: no value
out vec4 colour;

// Viridis colour map, identical to the one in src/gui/look/surface_values.h.
vec3 scale_colour(float t) {
  const vec3 c0 = vec3(0.2777273, 0.0054073, 0.3340998);
  const vec3 c1 = vec3(0.1050930, 1.4046135, 1.3845902);
  const vec3 c2 = vec3(-0.3308618, 0.2148476, 0.0950952);
  const vec3 c3 = vec3(-4.6342305, -5.7991010, -19.3324410);
  const vec3 c4 = vec3(6.2282699, 14.1799334, 56.6905526);
  const vec3 c5 = vec3(4.7763850, -13.7451454, -65.3530326);
  const vec3 c6 = vec3(-5.4354558, 4.6458526, 26.3124352);
  return c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * c6)))));
}

void main() {
  vec3 base = mesh_colour.rgb;
  if (most_mm > 0.0) base = value < 0.0 ? vec3(0.55) : scale_colour(clamp(value / most_mm, 0.0, 1.0));
  vec3 n = normalize(eye_normal);
  if (!gl_FrontFacing) n = -n;
  vec3 to_eye = normalize(-eye_position);
  vec3 lamp = normalize(vec3(-0.35, 0.5, 1.0));
  float diffuse = max(dot(n, lamp), 0.0);
  float fill = max(dot(n, normalize(vec3(0.5, -0.6, 0.3))), 0.0);
  float highlight = pow(max(dot(n, normalize(lamp + to_eye)), 0.0), 40.0);
  vec3 lit = base * (0.16 + 0.78 * diffuse + 0.16 * fill) + vec3(0.22 * highlight);
  colour = vec4(lit, mesh_colour.a);
}
