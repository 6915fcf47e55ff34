#version 460
#extension GL_GOOGLE_include_directive : require
// Evaluates queries of directions with the source of frames. The Rust side is src/render/evaluator.rs.
#include "brdf.glsl"
#include "part.glsl"
layout(push_constant) uniform Eval { Part part; uint count; float deviation; }; // of the footprint
#include "reads.glsl"
#include "source.glsl"

layout(local_size_x = 64) in;

struct Query {
    vec4 light; // xyz: to the light; w: wavenumber [1/um], or 0 for the colour
    vec4 view;  // xyz: to the viewer
};

layout(set = 0, binding = 0, std430) readonly buffer Queries { Query queries[]; };
layout(set = 0, binding = 1, std430) writeonly buffer Answers { vec4 answers[]; }; // f cos(theta_i): value or XYZ

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= count) {
        return;
    }
    Query query = queries[i];
    Pair pair = pair_of(query.light.xyz, query.view.xyz, source.medium);
    vec4 answer = vec4(0.0);
    if (query.light.w == 0.0) {
        Footprint footprint = Footprint(vec2(deviation, 0.0), vec2(0.0, deviation));
        answer = vec4(source_xyz(pair, footprint) + source_specular(pair, footprint), 0.0);
    } else if (part.first == 0) {
        // The limit of energy of a single wavelength is divided by in f64.
        answer = vec4(source_spectral(pair, query.light.w) * pair.limit);
    }
    answers[i] = pair.factor.y > 0.0 ? answer : vec4(0.0);
}
