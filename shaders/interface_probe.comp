#version 460
#extension GL_GOOGLE_include_directive : require
// Reads every field of the shared blocks and writes it out in order, for tests that compare it with the values written
// by Rust.
#include "frame.glsl"
#include "brdf.glsl"
#include "reads.glsl"
#include "part.glsl"
const Part part = Part(0, 1);
#include "source_window.glsl"

layout(local_size_x = 1) in;

layout(set = 0, binding = 8, std430) writeonly buffer Answers { vec4 answers[]; };

void main() {
    int n = 0;
    for (int i = 0; i < 4; ++i) {
        answers[n++] = frame.clip_from_world[i];
    }
    answers[n++] = frame.viewer;
    answers[n++] = frame.base_color;
    answers[n++] = frame.grooves;
    answers[n++] = frame.surroundings;
    answers[n++] = vec4(frame.at.jitter, frame.at.footprint, float(frame.at.index));
    answers[n++] = vec4(float(frame.at.count), float(frame.at.seed), float(frame.at.turn), float(frame.at.parts));
    for (int i = 0; i < LIGHT_SLOTS; ++i) {
        Light light = frame.lights[i];
        answers[n++] = light.toward;
        answers[n++] = light.emitter;
        answers[n++] = light.irradiance;
        for (int j = 0; j < 4; ++j) {
            answers[n++] = light.shadow_from_world[j];
        }
    }
    answers[n++] = vec4(source.texture_size, source.origin);
    answers[n++] = vec4(source.texels_per_frequency, source.band);
    answers[n++] = vec4(source.sigma, source.half_range, source.column);
    answers[n++] = vec4(source.pairs_per_z, source.fewest_pairs, 0.0, 0.0);
    answers[n++] = vec4(float(UV_BINS), 0.0, 0.0, 0.0);
}
