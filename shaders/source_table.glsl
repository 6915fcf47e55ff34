// Reads a colour table: XYZ of q^2 |P|^2, summed over the spectrum, as cubics in |w| over -(u, v).
// Its CPU twin is src/render/color_table.

layout(constant_id = 10) const int MAX_TAPS = 1; // samples along a footprint; 0: the centre of the pixel alone

// X, Y and Z of piece after piece of the range of |w|; RGBA: the coefficients of a cubic. Mip levels have layers for all of them;
// where points are read, they stand beside each other, so that a direction reads from two places of the memory and not from six.
layout(set = 1, binding = 1) uniform sampler2DArray color_table;

layout(set = 1, binding = 0, std140) uniform Table {
    float normal_reflectance; // R0 of Schlick
    float sigma;           // of the window, or what stands for it [um]
    float texture_per_uv;  // texture coordinate per unit of u
    float texels_per_uv;   // of the finest level
    float unit;            // what a stored 1 stands for
    float finest;          // level that a footprint of one finest texel asks for: the samples' own width is taken off
    float pieces;          // of the range of |w|
    float near;            // |u| and |v| up to which the finer part is read, which a corner of the finest level holds
    float near_texture_per_uv;
    float near_centre;     // texture coordinate of u = v = 0 there
} source;

const float LEAST_RANGE = 1e-3; // of w^2, where only texels of the edge stand

// Where in w a direction reads.
struct Piece {
    float number;
    vec4 polynomial; // Chebyshev's, at the place in the piece
};

// `toward` allows |w| up to sqrt(4 - |toward|^2).
Piece piece_of(vec2 toward, float w) {
    float along = w * inversesqrt(max(4.0 - dot(toward, toward), LEAST_RANGE)) * source.pieces;
    float number = clamp(floor(along), 0.0, source.pieces - 1.0);
    float x = 2.0 * min(along - number, 1.0) - 1.0;
    return Piece(number, vec4(1.0, x, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x));
}

vec3 read_table(Piece piece, vec2 place, float level) {
    float layer = 3.0 * piece.number;
    return vec3(dot(textureLod(color_table, vec3(place, layer), level), piece.polynomial),
                dot(textureLod(color_table, vec3(place, layer + 1.0), level), piece.polynomial),
                dot(textureLod(color_table, vec3(place, layer + 2.0), level), piece.polynomial));
}

vec3 read_texel(vec4 polynomial, ivec3 at) {
    return vec3(dot(texelFetch(color_table, at, 0), polynomial),
                dot(texelFetch(color_table, at + ivec3(1, 0, 0), 0), polynomial),
                dot(texelFetch(color_table, at + ivec3(2, 0, 0), 0), polynomial));
}

// Linear between texels whose channels stand beside each other. No direction reaches the edge.
vec3 read_point(Piece piece, vec2 place) {
    vec2 texel = place * (source.texels_per_uv / source.texture_per_uv) - 0.5;
    vec2 whole = floor(texel);
    vec2 t = texel - whole;
    ivec3 at = ivec3(3 * int(whole.x), int(whole.y), int(piece.number));
    ivec3 right = ivec3(3, 0, 0), up = ivec3(0, 1, 0);
    vec3 lower = mix(read_texel(piece.polynomial, at), read_texel(piece.polynomial, at + right), t.x);
    vec3 upper = mix(read_texel(piece.polynomial, at + up), read_texel(piece.polynomial, at + up + right), t.x);
    return mix(lower, upper, t.y);
}

// XYZ of f cos(theta_i) [1/sr] where `toward` = -(u, v), from the finest level.
vec3 table_xyz(Pair pair, vec2 toward) {
    bool near = max(abs(toward.x), abs(toward.y)) < source.near;
    vec2 place = toward * (near ? source.near_texture_per_uv : source.texture_per_uv) + (near ? source.near_centre : 0.5);
    Piece piece = piece_of(toward, pair.w);
    vec3 xyz = MAX_TAPS == 0 ? read_point(piece, place) : read_table(piece, place, 0.0);
    return xyz * (pair.factor * source.sigma * source.sigma * source.unit);
}

// The same averaged over a footprint with the edges `dx` and `dy`: `MAX_TAPS` samples at most along its longer side, each of
// a level as wide as the shorter side or as their distance. The sides are those of a rectangle with the parallelogram's moments.
vec3 table_xyz(Pair pair, vec2 toward, vec2 dx, vec2 dy) {
    float xx = dx.x * dx.x + dy.x * dy.x, yy = dx.y * dx.y + dy.y * dy.y, xy = dx.x * dx.y + dy.x * dy.y;
    float mean = 0.5 * (xx + yy), half_difference = 0.5 * (xx - yy);
    float spread = sqrt(half_difference * half_difference + xy * xy);
    float longer = max(sqrt(mean + spread), 1e-9);
    float shorter = sqrt(max(mean - spread, 0.0));
    vec2 axis = half_difference > 0.0 ? vec2(spread + half_difference, xy) : vec2(xy, spread - half_difference);
    // A circle has no longer side.
    vec2 along = axis * (longer * inversesqrt(max(dot(axis, axis), 1e-30)));
    // Finer than the finest texel there is nothing to resolve.
    float least = 1.0 / source.texels_per_uv;
    float taps = clamp(ceil(longer / max(shorter, least)), 1.0, float(MAX_TAPS));
    float level = max(log2(max(shorter, longer / taps) * source.texels_per_uv) + source.finest, 0.0);
    vec2 step = along * (source.texture_per_uv / taps);
    vec2 place = toward * source.texture_per_uv + 0.5 - 0.5 * (taps - 1.0) * step;
    Piece piece = piece_of(toward, pair.w);
    vec3 sum = vec3(0.0);
    for (int tap = 0; tap < int(taps); ++tap) {
        sum += read_table(piece, place, level);
        place += step;
    }
    return sum * (pair.factor * source.sigma * source.sigma * source.unit / taps);
}

const bool SOURCE_READS_FOOTPRINT = MAX_TAPS > 0;

vec3 source_xyz(Pair pair, Footprint footprint) {
    // A point has no footprint to average over, whatever the table could.
    bool averaged = SOURCE_READS_FOOTPRINT && (dot(footprint.dx, footprint.dx) + dot(footprint.dy, footprint.dy)) > 0.0;
    if (averaged) {
        return table_xyz(pair, pair.toward, footprint.dx, footprint.dy);
    }
    return table_xyz(pair, pair.toward);
}

// A table has no single wavelength; nobody asks.
float source_spectral(Pair pair, float wavenumber) {
    return 0.0;
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(color_table, pixel, scattered, samples);
}
