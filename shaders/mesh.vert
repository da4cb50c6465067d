#version 450 core
// SPDX-License-Identifier: Apache-2.0
uniform mat4 clip_from_world;
uniform mat4 eye_from_world;
uniform vec4 cut[4];  // removes where dot(cut, position) > 0
layout(location = 0) in vec3 position_mm;
layout(location = 1) in vec3 normal;
layout(location = 2) in float value_mm;
out vec3 eye_position;
out vec3 eye_normal;
out float value;
out float gl_ClipDistance[4];

void main() {
  eye_position = (eye_from_world * vec4(position_mm, 1.0)).xyz;
  eye_normal = mat3(eye_from_world) * normal;
  value = value_mm;
  for (int n = 0; n < 4; ++n) gl_ClipDistance[n] = -dot(cut[n], vec4(position_mm, 1.0));
  gl_Position = clip_from_world * vec4(position_mm, 1.0);
}
