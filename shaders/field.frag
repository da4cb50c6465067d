#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Tints the slice in proportion to the foreground probability P, which is given on a box of voxels. Texels below
// field_floor encode the distance to the object (src/forces/step_view.h); P is about 0 there.
uniform sampler3D field;
uniform mat4 index_from_world;
uniform vec3 first_voxel;
uniform float field_floor;  // smallest sampler value (0 to 1) that is a probability
uniform vec4 tint;
in vec3 position_mm;
out vec4 colour;

void main() {
  vec3 size = vec3(textureSize(field, 0));
  vec3 voxel = (index_from_world * vec4(position_mm, 1.0)).xyz - first_voxel + 0.5;
  if (any(lessThan(voxel, vec3(0.0))) || any(greaterThan(voxel, size))) discard;
  float p = texture(field, voxel / size).r;
  if (p < field_floor) discard;
  colour = vec4(tint.rgb, tint.a * p);
}
