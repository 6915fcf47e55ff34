#version 460
#extension GL_GOOGLE_include_directive : require
// Measures the texture read rate of the source, with just enough arithmetic to keep the compiler from removing reads.
#include "brdf.glsl"
#include "part.glsl"
const Part part = Part(0, 1);
#include "reads.glsl"
#include "source.glsl"

layout(location = 0) out vec4 sum;

layout(push_constant) uniform Probe {
    int samples;
    int scattered; // 1: every pixel begins at a random place
} probe;

void main() {
    sum = source_reads(gl_FragCoord.xy, probe.scattered != 0, probe.samples);
}
