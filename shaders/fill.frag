#version 450 core
// SPDX-License-Identifier: Apache-2.0
uniform vec4 fill_colour;
out vec4 colour;

void main() { colour = fill_colour; }
