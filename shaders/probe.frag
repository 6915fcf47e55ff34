#version 460
#extension GL_GOOGLE_include_directive : require
// Reads the layers as fast as the device can: one bilinear sample after the other, walking outward and through the layers as
// the shading does, and no more arithmetic than it takes to keep the compiler from leaving a read out. Neighbouring pixels
// read neighbours, or each pixel reads somewhere else.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"

layout(location = 0) out vec4 sum;

layout(push_constant) uniform Probe {
    int samples;
    int scattered; // 1: every pixel begins at a place of its own
} probe;

// Multiplicative hashing (Knuth): spreads neighbours over the whole range.
vec2 elsewhere(uvec2 pixel) {
    uint h = (pixel.x * 2654435761u) ^ (pixel.y * 2246822519u);
    h = (h ^ (h >> 15)) * 3266489917u;
    return vec2(h & 0xffffu, h >> 16) / 65536.0;
}

void main() {
    sum = vec4(0.0);
    vec2 beside = (gl_FragCoord.xy * 0.25 + optics.origin) / optics.texture_size;
    vec2 place = mix(beside, elsewhere(uvec2(gl_FragCoord.xy)), float(probe.scattered));
    int layer = 0;
    if (LINES) {
        // As the frame reads them: neighbours along a line, pair beside pair.
        ivec3 size = PACKED ? textureSize(packed_lines, 0) * ivec3(2, 1, 1) : textureSize(lines, 0);
        ivec2 points = size.xy / ivec2(GROUPED, 1) - 4;
        vec2 from = probe.scattered != 0 ? place * vec2(points) : gl_FragCoord.xy;
        ivec2 at = ivec2(mod(from, vec2(points))) + 2;
        int pair = 0;
        for (int i = 0; i < probe.samples; ++i) {
            if (PACKED) {
                TwoPairs two = read_two_pairs(ivec3((at.x * GROUPED + pair) / 2, at.y, layer), place.x);
                sum += two.first + two.second;
                pair += 2;
                ++i;
            } else {
                sum += read_line(ivec3(at.x * GROUPED + pair, at.y, layer), place.x);
                pair += 1;
            }
            if (pair == GROUPED) {
                pair = 0;
                layer += 1;
                if (layer == size.z) {
                    layer = 0;
                    at.y = at.y < points.y ? at.y + 1 : 2;
                }
            }
        }
        return;
    }
    vec2 walk = vec2(1.5) / optics.texture_size;
    for (int i = 0; i < probe.samples; ++i) {
        sum += textureLod(layers, vec3(fract(place), layer), 0.0);
        layer += 1;
        if (layer == PAIRS * Z_BANDS) {
            layer = 0;
            place += walk;
        }
    }
}
