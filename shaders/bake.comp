#version 460
#extension GL_GOOGLE_include_directive : require
// Integrates the spectrum for places of a colour table: for (u, v) and for -(u, v), at every node of w. The layers are read
// once per wavelength and serve all nodes. Pair p of them is the polynomial T_p in k|w| (src/expansion/phase.rs), so that a
// recurrence stands in for a table of coefficients: those of every node would cost more to read than the layers.
#include "interface.glsl"
#include "spectrum.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 7) const int NODES = 8; // of w

// -(u, v) of the places to bake, with u <= 0.
layout(set = 0, binding = 7, std430) readonly buffer Places { vec2 places[]; };

// XYZ at each place, [sign][node][channel][place].
layout(set = 0, binding = 8, std430) writeonly buffer Sums { float sums[]; };

layout(push_constant) uniform Tile {
    uint first;       // of `places`
    uint count;
    int comb;         // row of `nodes`
    int wavelengths;
    float x_per_z;    // 2 over the largest k|w|
    int pieces;       // of the range of w, four nodes each
} tile;

const float PI = 3.14159265358979;
const float LEAST_RANGE = 1e-3; // of w^2, as in table.glsl

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= tile.count) {
        return;
    }
    vec2 toward = places[tile.first + i]; // a table is over -(u, v): the sum of both directions along the surface
    float largest_w = sqrt(max(4.0 - dot(toward, toward), LEAST_RANGE));
    float w[NODES];
    vec3 with[NODES];
    vec3 against[NODES];
    for (int m = 0; m < NODES; ++m) {
        // Chebyshev's points of each piece.
        float along = float(m / 4) + 0.5 - 0.5 * cos(PI * (float(m % 4) + 0.5) / 4.0);
        w[m] = largest_w * along / float(tile.pieces);
        with[m] = vec3(0.0);
        against[m] = vec3(0.0);
    }
    for (int j = 0; j < tile.wavelengths; ++j) {
        vec4 weight = texelFetch(nodes, ivec2(j, tile.comb), 0);
        float wavenumber = weight.w;
        vec2 frequency = toward * wavenumber;
        if (any(greaterThan(abs(frequency), optics.band))) {
            break; // wavenumbers grow
        }
        Read read = read_at(frequency);
        // All reads first: unrolled, what they give stays at hand for every node.
        vec4 s[PAIRS];
        for (int p = 0; p < PAIRS; ++p) {
            s[p] = read_layer(read, p);
        }
        vec3 density = weight.xyz * (wavenumber * wavenumber);
        float twice_per_w = 4.0 * PI * wavenumber * tile.x_per_z;
        for (int m = 0; m < NODES; ++m) {
            float twice = w[m] * twice_per_w - 2.0;
            float before = 1.0, own = 0.5 * twice; // T_0 and T_1
            vec4 sum = s[0]; // of the real parts of e^{izh} (xy) and of the imaginary ones (zw)
            for (int p = 1; p < PAIRS; ++p) {
                sum += own * s[p];
                float after = twice * own - before;
                before = own;
                own = after;
            }
            // P = C + iS; where the layers are conjugated, |C* + iS*| = |C - iS|.
            vec4 parts = vec4(sum.x - sum.w, sum.y + sum.z, sum.x + sum.w, sum.y - sum.z);
            parts *= parts;
            with[m] += density * (parts.x + parts.y);
            against[m] += density * (parts.z + parts.w);
        }
    }
    for (int m = 0; m < NODES; ++m) {
        for (int c = 0; c < 3; ++c) {
            sums[uint(m * 3 + c) * tile.count + i] = with[m][c];
            sums[uint((NODES + m) * 3 + c) * tile.count + i] = against[m][c];
        }
    }
}
