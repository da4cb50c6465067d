#version 450 core
// SPDX-License-Identifier: Apache-2.0
uniform mat4 clip_from_world;
uniform mat4 eye_from_world;
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal;
layout(location = 2) in float value_mm;
out vec3 eye_position;
out vec3 eye_normal;
out float value;

void main() {
  eye_position = (eye_from_world * vec4(position_mm, 1.0)).xyz;
  eye_normal = mat3(eye_from_world) * normal;
  value = value_mm;
  gl_Position = clip_from_world * vec4(position_mm, 1.0);
}
