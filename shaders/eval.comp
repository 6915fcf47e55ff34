#version 460
#extension GL_GOOGLE_include_directive : require
// Answers queries of directions with the optics that the frame shades with.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"

layout(local_size_x = 64) in;

struct Query {
    vec4 light; // xyz: to the light; w: wavenumber [1/um], or 0 for the colour
    vec4 view;  // xyz: to the viewer
};

layout(set = 0, binding = 7, std430) readonly buffer Queries { Query queries[]; };
layout(set = 0, binding = 8, std430) writeonly buffer Answers { vec4 answers[]; }; // f cos(theta_i): value or XYZ

layout(push_constant) uniform Count { uint count; } total;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= total.count) {
        return;
    }
    Query query = queries[i];
    Pair pair = pair_of(query.light.xyz, query.view.xyz);
    answers[i] = query.light.w > 0.0 ? vec4(cosine_weighted(pair, query.light.w))
                                     : vec4(cosine_weighted_xyz(pair), 0.0);
}
