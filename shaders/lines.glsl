// Colours from spectra on the lines of a grid: the nodes of the integral over the spectrum stand where the ray -(u, v)/lambda
// crosses a line, so that a node is read from neighbours along that line. Its twin is src/precompute/lines.rs.

const int OCTAVES = 20;  // of rays near the mirror direction, with finer lines each
const float FINER = 4.0; // points of those lines to one of the others

layout(set = 1, binding = 5, std140) uniform Lines {
    vec2 across;                    // L across the lines of constant f_x and of constant f_y [um]: they stand at m/L
    vec2 along;                     // L along them [um]
    vec2 origin;                    // number of the point and of the line of f = 0
    float from;                     // max(|u|, |v|) from which on lines are read
    float unit;                     // intensities on lines over those of the plane
    float first_column;             // wavenumber of the first column of the weights [1/um]
    float columns_per_wavenumber;   // [um]
    float first_row;                // log2 of the first row's distance of nodes [1/um]
    float rows_per_octave;
    float last_column;
    float nearest;                  // max(|u|, |v|) that rays nearer to the mirror direction are taken for
    vec4 near[OCTAVES];             // xy: number of the point and of the line of f = 0, for each octave of rays below `from`
} lines_at;

// Spectra on lines: layer (pair / GROUPED) Z_BANDS + band, those of constant f_y behind all of constant f_x; row by line,
// column by point and, side by side, by pair of a group. RGBA as in `layers`.
layout(set = 1, binding = 6) uniform sampler2DArray lines;

// The same where numbers have 16 bits and an even number of pairs stands side by side: two pairs to a texel, half as many reads.
layout(set = 1, binding = 7) uniform usampler2DArray packed_lines;

// Weights of nodes that stand where a ray crosses lines: XYZ times the squared wavenumber, per distance of the nodes. W of the
// first two texels of a row: the wavenumbers between which the eye sees enough [1/um].
layout(set = 1, binding = 8) uniform sampler2D line_weights;

layout(constant_id = 20) const bool LINES = false;       // whether there are any
layout(constant_id = 21) const int GROUPED = 1;          // pairs of terms beside each other
layout(constant_id = 22) const bool CUBIC_LINES = false; // cubic B-spline along a line, else linear
layout(constant_id = 23) const bool PACKED = false;      // two pairs to a texel, one behind the last being 0

// Two pairs of terms.
struct TwoPairs {
    vec4 first;
    vec4 second;
};

// A texel of two pairs over 2^112, which is what the exponents' biases, 127 and 15, differ by: sign, exponent and mantissa of the 16-bit
// floats (IEEE 754), moved to where 32-bit floats have them. What GLSL has to unpack them takes software devices several times as long.
TwoPairs unpacked(uvec4 texel) {
    const int KEPT = int(0x8fffe000u);
    ivec4 bits = ivec4(texel);
    ivec4 low = ((bits << 16) >> 3) & KEPT, high = (bits >> 3) & KEPT;
    return TwoPairs(intBitsToFloat(ivec4(low.x, high.x, low.y, high.y)),
                    intBitsToFloat(ivec4(low.z, high.z, low.w, high.w)));
}

const float UNPACKED = 5.192296858534828e33; // 2^112

TwoPairs two_pairs_at(ivec3 at) {
    return unpacked(texelFetch(packed_lines, at, 0));
}

// Two pairs of terms at `t` in 0 ... 1 between the texel `at` and its neighbour along the line, over 2^112.
TwoPairs read_two_pairs(ivec3 at, float t) {
    ivec3 next = ivec3(GROUPED / 2, 0, 0);
    TwoPairs b = two_pairs_at(at), c = two_pairs_at(at + next);
    if (!CUBIC_LINES) {
        return TwoPairs(mix(b.first, c.first, t), mix(b.second, c.second, t));
    }
    TwoPairs a = two_pairs_at(at - next), d = two_pairs_at(at + 2 * next);
    vec4 w = spline_weights(t);
    return TwoPairs(w.x * a.first + w.y * b.first + w.z * c.first + w.w * d.first,
                    w.x * a.second + w.y * b.second + w.z * c.second + w.w * d.second);
}

// A pair of terms at `t` in 0 ... 1 between the texel `at` and its neighbour along the line.
vec4 read_line(ivec3 at, float t) {
    ivec3 next = ivec3(GROUPED, 0, 0);
    if (!CUBIC_LINES) {
        return mix(texelFetch(lines, at, 0), texelFetch(lines, at + next, 0), t);
    }
    vec4 w = spline_weights(t);
    return w.x * texelFetch(lines, at - next, 0) + w.y * texelFetch(lines, at, 0)
           + w.z * texelFetch(lines, at + next, 0) + w.w * texelFetch(lines, at + 2 * next, 0);
}

// A node: where a ray crosses a line.
struct Node {
    ivec2 at;    // texel of the first pair, and line
    float t;     // from there to the next point
    int layer;   // of the first group of pairs
    int band;    // of z
};

int layer_of(Node node, int pair) {
    return node.layer + pair / GROUPED * Z_BANDS + node.band;
}

// Sum of the terms of a pair.
vec2 sum_of_pair(Node node, int pair, inout Coefficients c) {
    vec4 s = read_line(ivec3(node.at.x + pair % GROUPED, node.at.y, layer_of(node, pair)), node.t);
    return next_terms(c, pair * Z_BANDS + node.band, s);
}

// Sum of the terms of a pair and the next, over 2^112.
vec2 sum_of_two_pairs(Node node, int pair, inout Coefficients c) {
    ivec2 at = ivec2((node.at.x + pair % GROUPED) / 2, node.at.y);
    TwoPairs s = read_two_pairs(ivec3(at, layer_of(node, pair)), node.t);
    vec2 sum = next_terms(c, pair * Z_BANDS + node.band, s.first);
    if (pair + 1 < PAIRS) {
        sum += next_terms(c, (pair + 1) * Z_BANDS + node.band, s.second);
    }
    return sum;
}

// Sum of the terms that k|w| = z needs.
vec2 sum_at(Node node, float z, Coefficients c) {
    if (!PACKED) {
        int count = FEWER_PAIRS ? pairs_at(z) : PAIRS, pair = 0;
        vec2 p = vec2(0.0);
        do {
            p += sum_of_pair(node, pair, c);
            ++pair;
        } while (pair < count);
        return p;
    }
    vec2 p = sum_of_two_pairs(node, 0, c);
    if (FEWER_PAIRS || PAIRS > 8) {
        int count = FEWER_PAIRS ? pairs_at(z) : PAIRS;
        for (int pair = 2; pair < count; pair += 2) {
            p += sum_of_two_pairs(node, pair, c);
        }
    } else {
        // One after the other: software devices take a sixth longer for a loop.
        if (PAIRS > 2) {
            p += sum_of_two_pairs(node, 2, c);
        }
        if (PAIRS > 4) {
            p += sum_of_two_pairs(node, 4, c);
        }
        if (PAIRS > 6) {
            p += sum_of_two_pairs(node, 6, c);
        }
    }
    return p * UNPACKED;
}

// XYZ of q^2 |P|^2, summed over the lines that a ray crosses up to the wavenumber `largest`; nothing where that is 0.
vec3 sum_over_lines(Ray toward, float largest) {
    bool second = abs(toward.toward.y) > abs(toward.toward.x);
    vec2 ray = second ? toward.toward.yx : toward.toward; // across the lines, along them
    float conjugate = toward.conjugate;
    if (HALF_PLANE && ray.x < 0.0) {
        ray = -ray;
        conjugate = -conjugate;
    }
    // Rays that cross too few lines have finer ones, by octaves of their reach; the last octave serves all that is left.
    float reach = max(abs(ray.x), lines_at.nearest);
    bool far = reach >= lines_at.from;
    int octave = clamp(int(log2(lines_at.from / reach)), 0, OCTAVES - 1);
    vec2 origin = far ? lines_at.origin : lines_at.near[octave].xy;
    float finer = far ? 1.0 : exp2(float(octave + 1));
    float per_wavenumber = reach * finer * (second ? lines_at.across.y : lines_at.across.x); // lines
    float step = 1.0 / max(per_wavenumber, 1e-6);
    int row = clamp(int((log2(step) - lines_at.first_row) * lines_at.rows_per_octave + 0.5), 0,
                    textureSize(line_weights, 0).y - 1);
    // The wavenumbers that the eye sees enough of. They stand in the texture because lavapipe (Mesa 22.3) crashes where the
    // end of a loop follows from a uniform in this way.
    vec2 range = vec2(texelFetch(line_weights, ivec2(0, row), 0).w, texelFetch(line_weights, ivec2(1, row), 0).w);
    int first = int(ceil(range.x * per_wavenumber - 1.0));
    int last = largest > 0.0 ? int(floor(min(range.y * per_wavenumber + 1.0, largest * per_wavenumber))) : -1;
    float points_per_line = ray.y * step * (far ? 1.0 : FINER) * (second ? lines_at.along.y : lines_at.along.x);
    int side = ray.x < 0.0 ? -1 : 1;
    int behind = second ? (PAIRS + GROUPED - 1) / GROUPED * Z_BANDS : 0;
    float bands_per_line = 2.0 * PI * toward.w * source.bands_per_z * step;
    float column_per_line = step * lines_at.columns_per_wavenumber;
    float first_column = -lines_at.first_column * lines_at.columns_per_wavenumber;
    vec3 xyz = vec3(0.0);
    if (first > last) {
        return xyz;
    }
    // Tested at its end, as the loop of `power` is.
    int line = first;
    do {
        float number = float(line);
        float point = number * points_per_line + origin.x;
        float whole = floor(point);
        float place = number * bands_per_line;
        Node node;
        node.at = ivec2(int(whole) * GROUPED, int(origin.y) + side * line);
        node.t = point - whole;
        node.layer = behind;
        node.band = min(int(place), Z_BANDS - 1);
        Coefficients c = coefficients_from(min(place - float(node.band), 1.0), conjugate);
        vec2 p = sum_at(node, place / source.bands_per_z, c);
        float weight = clamp(number * column_per_line + first_column, 0.0, lines_at.last_column);
        xyz += texelFetch(line_weights, ivec2(int(weight), row), 0).xyz * dot(p, p);
        ++line;
    } while (line <= last);
    return xyz * (step * lines_at.unit);
}
