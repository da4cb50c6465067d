#version 450 core
// SPDX-License-Identifier: Apache-2.0
// A lamp beside the eye, a weak one from below, a small highlight (Blinn-Phong).
uniform vec4 mesh_colour;
in vec3 eye_position;
in vec3 eye_normal;
out vec4 colour;

void main() {
  vec3 n = normalize(eye_normal);
  if (!gl_FrontFacing) n = -n;
  vec3 to_eye = normalize(-eye_position);
  vec3 lamp = normalize(vec3(-0.35, 0.5, 1.0));
  float diffuse = max(dot(n, lamp), 0.0);
  float fill = max(dot(n, normalize(vec3(0.5, -0.6, 0.3))), 0.0);
  float highlight = pow(max(dot(n, normalize(lamp + to_eye)), 0.0), 40.0);
  vec3 lit = mesh_colour.rgb * (0.16 + 0.78 * diffuse + 0.16 * fill) + vec3(0.22 * highlight);
  colour = vec4(lit, mesh_colour.a);
}
