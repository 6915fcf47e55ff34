#version 460
#extension GL_GOOGLE_include_directive : require
// Answers queries of directions with the colours that `repeats.frag` shades with.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "repeats.glsl"

layout(local_size_x = 64) in;

struct Query {
    vec4 light; // xyz: to the light
    vec4 view;  // xyz: to the viewer
};

layout(set = 0, binding = 7, std430) readonly buffer Queries { Query queries[]; };
layout(set = 0, binding = 8, std430) writeonly buffer Answers { vec4 answers[]; }; // XYZ of f cos(theta_i)

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= asked) {
        return;
    }
    answers[i] = vec4(repeated_xyz(pair_of(queries[i].light.xyz, queries[i].view.xyz)), 0.0);
}
