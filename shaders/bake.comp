#version 460
#extension GL_GOOGLE_include_directive : require
// Integrates the spectrum for places of a colour table: for (u, v) and for -(u, v), at every node of w. The layers are read
// once per wavelength and serve all nodes. Pair p of them is the polynomial T_p in k|w| (src/expansion/phase.rs), so that a
// recurrence stands in for a table of coefficients: those of every node would cost more to read than the layers.
#include "brdf.glsl"
#include "spectra.glsl"
#include "orders.glsl"

layout(local_size_x = 64) in;

layout(constant_id = 0) const int NODES = 8; // of w
layout(constant_id = 1) const bool REPEATS = false; // layers of one period, wavelengths at the orders

// -(u, v) of the places to bake, with u <= 0.
layout(set = 0, binding = 0, std430) readonly buffer Places { vec2 places[]; };

// XYZ at each place, [sign][node][channel][place].
layout(set = 0, binding = 1, std430) writeonly buffer Sums { float sums[]; };

layout(push_constant) uniform Tile {
    uint first;       // of `places`
    uint count;
    int comb;         // row of `nodes`, and
    int wavelengths;  // nodes of it, where there is a window
    float x_per_z;    // 2 over the largest k|w|
    int pieces;       // of the range of w, four nodes each
    Copies copies;    // where there are repeats
} tile;

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
    Sampling s;
    ivec2 ends = ivec2(0, tile.wavelengths);
    if (REPEATS) {
        s = sampling(tile.copies, toward);
        ends = seen_orders(s);
    }
    for (int j = ends.x; j < ends.y; ++j) {
        float wavenumber;
        vec3 weight;
        if (REPEATS) {
            vec2 order = order_at(s, j);
            wavenumber = order.x;
            weight = colour_density(wavenumber) * (order.y / s.periods);
        } else {
            vec4 node = texelFetch(nodes, ivec2(j, tile.comb), 0);
            wavenumber = node.w;
            weight = node.xyz;
        }
        vec2 frequency = toward * wavenumber;
        if (any(greaterThan(abs(frequency), source.band))) {
            break; // wavenumbers grow
        }
        Read read = read_at(frequency);
        // All reads first: unrolled, what they give stays at hand for every node.
        vec4 terms[PAIRS];
        for (int p = 0; p < PAIRS; ++p) {
            terms[p] = read_layer(read, p);
        }
        vec3 density = weight * (wavenumber * wavenumber);
        float twice_per_w = 4.0 * PI * wavenumber * tile.x_per_z;
        for (int m = 0; m < NODES; ++m) {
            float twice = w[m] * twice_per_w - 2.0;
            float before = 1.0, own = 0.5 * twice; // T_0 and T_1
            vec4 sum = terms[0]; // of the real parts of e^{izh} (xy) and of the imaginary ones (zw)
            for (int p = 1; p < PAIRS; ++p) {
                sum += own * terms[p];
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
