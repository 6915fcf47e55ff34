// Colour table: the mean over coherence areas, summed over the spectrum, over -(u, v), in levels that average over
// growing Gaussians in (u, v). Texels hold coordinates in a basis of functions of |w| (src/table/basis.rs). Its CPU
// twin is src/table/read.rs; the Rust side is src/render/source/table.rs.
// The arithmetic is in table.glsl, which exports hold, too.
#extension GL_EXT_control_flow_attributes : require
#define UNROLL [[unroll]]
#include "footprint.glsl"

layout(constant_id = 11) const int TEXELS = 3; // texels per direction and tap, of four coordinates each
layout(constant_id = 16) const int BANDS = 64; // of wavelengths of the specular order, a power of 4

// TEXELS layers for each piece of the range of |w|, first of level 2m and then of level 2m + 1 in mip level m.
layout(set = 1, binding = 3) uniform sampler2DArray color_table;

// XYZ of the specular order over |w| and its variance in (u, v): one row per band of wavelengths, then rows of the sums of 4, 16 ... and at last of
// all bands; the last row holds the mean R of a material over twice the cosine of the half angle, or 1.
layout(set = 1, binding = 4) uniform sampler2D specular;

// Basis functions, one row per piece: X, Y and Z of one coordinate after the other; RGBA: coefficients of 1, t, t^2 and
// t^3.
layout(set = 1, binding = 5) uniform sampler2D basis;

layout(set = 1, binding = 2, std140) uniform Table {
    float texture_per_uv;     // texture coordinate per unit of u
    float coherence;          // variance of u due to coherence
    float unit;               // BRDF value of a stored 1 [1/sr]
    float finest;             // variance of u of the finest level
    float per_growth;         // reciprocal of the variance added by level 1
    float pieces;             // of 0 ... LARGEST_W
    float last_level;
    Medium medium;            // refractive indices of the surface, unless sums over wavelengths contain all of it
} source;

vec4 table_texel(vec3 place, float mip) {
    return textureLod(color_table, place, mip);
}

vec4 table_cubic(int column, int piece) {
    return texelFetch(basis, ivec2(column, piece), 0);
}

vec4 table_row(float place, int row) {
    vec2 size = vec2(textureSize(specular, 0));
    return textureLod(specular, vec2(place * (size.x - 1.0) + 0.5, float(row) + 0.5) / size, 0.0);
}

#include "table.glsl"

vec3 source_specular(Pair pair, Footprint footprint) {
    return table_specular(pair, footprint);
}

// Returns the specular order, integrated over (u, v).
vec3 source_mirrored(Pair pair) {
    return table_row(pair.w / LARGEST_W, MEAN_ROW - 1).rgb * table_factor(pair);
}

const bool SOURCE_READS_FOOTPRINT = true;

vec3 source_xyz(Pair pair, Footprint footprint) {
    return table_scattered(pair, footprint);
}

// Returns the average over a round footprint of this radius.
vec3 source_round_xyz(Pair pair, float radius) {
    return table_round(pair, radius * radius);
}

// Never used: a table has no single wavelengths.
float source_spectral(Pair pair, float wavenumber) {
    return 0.0;
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(color_table, pixel, scattered, samples);
}
