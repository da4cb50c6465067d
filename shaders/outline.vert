#version 450 core
// SPDX-License-Identifier: Apache-2.0
uniform vec4 plane;  // unit normal, and minus its distance from the origin in mm
layout(location = 0) in vec3 position_mm;
out vec3 corner_mm;
out float height_mm;

void main() {
  corner_mm = position_mm;
  height_mm = dot(plane, vec4(position_mm, 1.0));
}
