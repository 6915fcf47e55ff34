#version 460
#extension GL_GOOGLE_include_directive : require
// Answers queries of directions from the colour table that frames shade with, at its finest level.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "table.glsl"

layout(local_size_x = 64) in;

struct Query {
    vec4 light; // xyz: to the light
    vec4 view;  // xyz: to the viewer
};

layout(set = 0, binding = 7, std430) readonly buffer Queries { Query queries[]; };
layout(set = 0, binding = 8, std430) writeonly buffer Answers { vec4 answers[]; }; // f cos(theta_i): XYZ

layout(push_constant) uniform Count { uint count; } total;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= total.count) {
        return;
    }
    Query query = queries[i];
    Pair pair = pair_of(query.light.xyz, query.view.xyz);
    vec3 xyz = table_xyz(pair, query.light.xy + query.view.xy);
    answers[i] = vec4(pair.factor > 0.0 ? xyz : vec3(0.0), 0.0);
}
