#version 460
#extension GL_GOOGLE_include_directive : require
// Reads the layers as fast as the device can: one bilinear sample after the other, neighbours for neighbouring pixels,
// walking outward and through the layers as the shading does, and no more arithmetic than it takes to keep the compiler
// from leaving a read out.
#include "interface.glsl"
#include "spectrum.glsl"

layout(location = 0) out vec4 sum;

layout(push_constant) uniform Probe { int samples; } probe;

void main() {
    sum = vec4(0.0);
    vec2 place = (gl_FragCoord.xy * 0.25 + optics.origin) / optics.texture_size;
    vec2 walk = vec2(1.5) / optics.texture_size;
    int layer = 0;
    for (int i = 0; i < probe.samples; ++i) {
        sum += textureLod(layers, vec3(fract(place), layer), 0.0);
        layer += 1;
        if (layer == PAIRS * Z_BANDS) {
            layer = 0;
            place += walk;
        }
    }
}
