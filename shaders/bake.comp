#version 460
#extension GL_GOOGLE_include_directive : require
// Integrates the spectrum for texels of a colour table: for (u, v) and for -(u, v), at every node of w. The layers are read
// once per wavelength and serve all of them.
#include "interface.glsl"
#include "spectrum.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const int NODES = 8; // of w

// Texels to bake: column and row of a square table, both halves of a word; all have |(u, v)| in one bin of wavelengths.
layout(set = 0, binding = 7, std430) readonly buffer Places { uint places[]; };

// XYZ at each place, [sign][node][channel][place].
layout(set = 0, binding = 8, std430) writeonly buffer Sums { float sums[]; };

// The comb of these texels. For each wavelength: XYZ weight times q^2 and the wavenumber q; then the coefficients c_n(2 pi q w),
// [pair of terms][node].
layout(set = 0, binding = 4, std430) readonly buffer Steps { vec4 steps[]; };

layout(push_constant) uniform Tile {
    uint first;       // of `places`
    uint count;
    uint first_step;  // of `steps`
    uint wavelengths;
    uint pairs;       // that these texels need
    float spacing;    // of the table
    float centre;     // texel of u = v = 0
} tile;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= tile.count) {
        return;
    }
    uint place = places[tile.first + i];
    // A table is over -(u, v): the sum of both directions along the surface.
    vec2 toward = (vec2(float(place & 0xffffu), float(place >> 16)) - tile.centre) * tile.spacing;
    vec3 with[NODES];
    vec3 against[NODES];
    for (int m = 0; m < NODES; ++m) {
        with[m] = vec3(0.0);
        against[m] = vec3(0.0);
    }
    uint stride = 1 + tile.pairs * NODES;
    for (uint j = 0; j < tile.wavelengths; ++j) {
        uint step = tile.first_step + j * stride;
        vec4 weight = steps[step];
        vec2 frequency = toward * weight.w;
        if (any(greaterThan(abs(frequency), optics.band))) {
            break; // wavenumbers grow
        }
        Read read = read_at(frequency);
        // Sums of products of real and imaginary parts: P(f) and the P(-f) of conjugated layers are made of the same four.
        vec4 parts[NODES];
        for (int m = 0; m < NODES; ++m) {
            parts[m] = vec4(0.0);
        }
        for (uint p = 0; p < tile.pairs; ++p) {
            vec4 s = read_layer(read, int(p));
            for (int m = 0; m < NODES; ++m) {
                vec4 c = steps[step + 1 + p * NODES + m];
                parts[m] += c.xyxy * s.xyyx + c.zwzw * s.zwwz; // re re, im im, re im, im re
            }
        }
        for (int m = 0; m < NODES; ++m) {
            vec4 q = parts[m];
            float difference = q.x - q.y, sum = q.z + q.w;
            with[m] += weight.xyz * (difference * difference + sum * sum);
            sum = q.x + q.y;
            difference = q.w - q.z;
            against[m] += weight.xyz * (sum * sum + difference * difference);
        }
    }
    for (int m = 0; m < NODES; ++m) {
        for (int c = 0; c < 3; ++c) {
            sums[uint(m * 3 + c) * tile.count + i] = with[m][c];
            sums[uint((NODES + m) * 3 + c) * tile.count + i] = against[m][c];
        }
    }
}
