#version 460
#extension GL_GOOGLE_include_directive : require
// Reads the source's texture as fast as the device can, with no more arithmetic than it takes to keep the compiler from leaving a read
// out.
#include "brdf.glsl"
#include "part.glsl"
const Part part = Part(0, 1);
#include "reads.glsl"
#include "source.glsl"

layout(location = 0) out vec4 sum;

layout(push_constant) uniform Probe {
    int samples;
    int scattered; // 1: every pixel begins at a place of its own
} probe;

void main() {
    sum = source_reads(gl_FragCoord.xy, probe.scattered != 0, probe.samples);
}
