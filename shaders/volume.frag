#version 450 core
// SPDX-License-Identifier: Apache-2.0
// Casts one ray per pixel through a 3D texture, from near_depth to far_depth of the window.
// mode 0: composites from front to back; opacity by window and level, shading by the gradient (Levoy, Display of
// surfaces from volume data, 1988). mode 1: colour of the largest value. mode 2: the largest value and its depth.
layout(binding = 0) uniform sampler3D volume;
layout(binding = 1) uniform sampler2D far_depth;
layout(binding = 2) uniform sampler2D near_depth;
uniform float mode;
uniform float ends_at_depth;    // 1: rays end at far_depth
uniform float begins_at_depth;  // 1: rays begin at near_depth
uniform vec2 viewport_px;
uniform mat4 texture_from_clip;
uniform mat4 clip_from_texture;
uniform mat4 world_from_texture;
uniform mat4 eye_from_gradient;  // normal in the eye frame, from differences between texels
uniform vec3 extent;            // texture coordinates of the outer corner of the volume
uniform vec4 cut[4];            // removes where dot(cut, texture position) > 0
uniform float low;              // values shown as black and as white
uniform float high;
uniform float inverted;   // 1: low values are bright
uniform float density;    // extinction by white voxels, 1/mm
uniform float spacing;    // distance of samples, texels
out vec4 colour;

vec2 ndc;

vec3 at_depth(float z) {
  vec4 p = texture_from_clip * vec4(ndc, z, 1.0);
  return p.xyz / p.w;
}

float value(vec3 p) { return textureLod(volume, p, 0.0).r; }

// Fixed noise in 0..1, which hides the rings of equal sampling depths.
float noise() { return fract(52.9829189 * fract(dot(gl_FragCoord.xy, vec2(0.06711056, 0.00583715)))); }

void main() {
  vec2 screen = gl_FragCoord.xy / viewport_px;
  ndc = screen * 2.0 - 1.0;
  vec3 a = at_depth(-1.0);
  vec3 along = at_depth(1.0) - a;
  float first = 0.0, last = 1.0;
  // The outer faces of the volume.
  vec3 inverse = 1.0 / along;
  vec3 t0 = -a * inverse, t1 = (extent - a) * inverse;
  vec3 enter = min(t0, t1), leave = max(t0, t1);
  first = max(first, max(enter.x, max(enter.y, enter.z)));
  last = min(last, min(leave.x, min(leave.y, leave.z)));
  for (int n = 0; n < 4; ++n) {
    float from = dot(cut[n], vec4(a, 1.0)), change = dot(cut[n].xyz, along);
    if (change < 0.0) first = max(first, -from / change);
    else if (change > 0.0) last = min(last, -from / change);
    else if (from > 0.0) last = -1.0;
  }
  if (ends_at_depth > 0.5) {
    vec3 end = at_depth(texture(far_depth, screen).r * 2.0 - 1.0);
    last = min(last, dot(end - a, along) / dot(along, along));
  }
  if (begins_at_depth > 0.5) {
    vec3 begin = at_depth(texture(near_depth, screen).r * 2.0 - 1.0);
    first = max(first, dot(begin - a, along) / dot(along, along));
  }
  colour = vec4(0.0);
  if (mode > 1.5) colour = vec4(-1.0, 1.0, 0.0, 0.0);
  if (first >= last) {
    if (mode < 1.5) discard;
    return;
  }
  vec3 size = vec3(textureSize(volume, 0)), texels = abs(along) * size;
  int count = int(clamp(ceil(max(texels.x, max(texels.y, texels.z)) * (last - first) / spacing), 1.0, 4096.0));
  float dt = (last - first) / float(count);

  if (mode > 0.5) {
    float most = -1.0, t_most = last;
    for (int n = 0; n < count; ++n) {
      float t = first + (float(n) + 0.5) * dt;
      float v = value(a + t * along);
      if (v > most) {
        most = v;
        t_most = t;
      }
    }
    if (mode > 1.5) {
      vec4 clip = clip_from_texture * vec4(a + t_most * along, 1.0);
      colour = vec4(most, clip.z / clip.w * 0.5 + 0.5, 0.0, 0.0);
      return;
    }
    float bright = clamp((most - low) / (high - low), 0.0, 1.0);
    colour = vec4(vec3(inverted > 0.5 ? 1.0 - bright : bright), bright);
    return;
  }

  vec3 sum = vec3(0.0);
  float through = 1.0;
  float start = noise();
  mat3 normal_from_gradient = mat3(eye_from_gradient);
  vec3 texel = 1.0 / size;
  float step_mm = dt * length(mat3(world_from_texture) * along);
  for (int n = 0; n < count && through > 0.02; ++n) {
    vec3 p = a + (first + (float(n) + start) * dt) * along;
    float bright = clamp((value(p) - low) / (high - low), 0.0, 1.0);
    if (bright <= 0.003) continue;
    float opacity = 1.0 - exp(-density * bright * bright * step_mm);
    vec3 gradient = vec3(value(p + vec3(texel.x, 0.0, 0.0)) - value(p - vec3(texel.x, 0.0, 0.0)),
                         value(p + vec3(0.0, texel.y, 0.0)) - value(p - vec3(0.0, texel.y, 0.0)),
                         value(p + vec3(0.0, 0.0, texel.z)) - value(p - vec3(0.0, 0.0, texel.z)));
    // Inside homogeneous tissue the gradient is noise: there, the light comes from everywhere.
    float edge = smoothstep(0.02, 0.2, length(gradient) / (high - low));
    vec3 normal = normal_from_gradient * gradient;
    float size_of_normal = length(normal);
    normal = size_of_normal > 0.0 ? normal / size_of_normal : vec3(0.0, 0.0, 1.0);
    vec3 lamp = normalize(vec3(-0.35, 0.5, 1.0));
    float lit = 0.22 + 0.78 * abs(dot(normal, lamp));
    sum += through * opacity * mix(0.62, lit, edge) * mix(vec3(0.80, 0.74, 0.70), vec3(1.0, 0.98, 0.94), bright);
    through *= 1.0 - opacity;
  }
  float alpha = 1.0 - through;
  if (alpha <= 0.0) discard;
  colour = vec4(sum / alpha, alpha);
}
