#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the directions that `diffraction.frag` shades, for a reference to shade the very same ones.
#include "interface.glsl"

layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 lights[MAX_LIGHTS];

layout(location = 0) out vec4 to_light; // w: covered
layout(location = 1) out vec4 to_view;  // w: covered

layout(push_constant) uniform Which { int light; } which;

void main() {
    to_light = vec4(normalize(lights[which.light]), 1.0);
    to_view = vec4(normalize(view), 1.0);
}
