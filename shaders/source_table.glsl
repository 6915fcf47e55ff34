// Colour table: the mean over coherence areas, summed over the spectrum, over -(u, v), in mip levels that average over
// growing Gaussians in (u, v). Texels hold coordinates in a basis of functions of |w| (src/table/basis.rs). Its CPU
// twin is src/table/read.rs; the Rust side is src/render/source/table.rs.
#extension GL_EXT_control_flow_attributes : require
#include "footprint.glsl"

layout(constant_id = 11) const int TEXELS = 3; // texels per direction and tap, of four coordinates each

// TEXELS layers for each piece of the range of |w|.
layout(set = 1, binding = 1) uniform sampler2DArray color_table;

// XYZ of the specular order over |w|: one row per band of wavelengths, then a row of the sum of all bands; the last row
// holds the mean R of a material over twice the cosine of the half angle, or 1.
layout(set = 1, binding = 2) uniform sampler2D specular;

// Basis functions, one row per piece: X, Y and Z of one coordinate after the other; RGBA: coefficients of 1, t, t^2 and
// t^3.
layout(set = 1, binding = 3) uniform sampler2D basis;

const int BANDS = 16;       // of wavelengths of the specular order
const float LARGEST_W = 2.0;

layout(set = 1, binding = 0, std140) uniform Table {
    float index;              // refractive index
    float texture_per_uv;     // texture coordinate per unit of u
    float coherence;          // variance of u due to coherence
    float unit;               // BRDF value of a stored 1 [1/sr]
    float finest;             // variance of u of the finest level
    float per_growth;         // reciprocal of the variance added per level
    float pieces;             // of 0 ... LARGEST_W
    float last_level;
    vec4 variances[BANDS / 4]; // of u in each band of the specular order
} source;

// Coordinates read at a position, of which the first TEXELS vectors are used.
struct Numbers {
    vec4 of_texel[3];
};

const Numbers NOTHING = Numbers(vec4[](vec4(0.0), vec4(0.0), vec4(0.0)));

// Position in the range of |w|: the piece, and t from -1 to 1 in it.
struct Piece {
    int number;
    float t;
};

Piece piece_of(float w) {
    float place = w * (source.pieces / LARGEST_W);
    float number = min(floor(place), source.pieces - 1.0);
    return Piece(int(number), 2.0 * (place - number) - 1.0);
}

// Adds `weight` times the coordinates at `place`.
void add_place(inout Numbers sum, float weight, vec3 place, float level) {
    [[unroll]] for (int i = 0; i < TEXELS; ++i) {
        sum.of_texel[i] += weight * textureLod(color_table, place + vec3(0.0, 0.0, float(i)), level);
    }
}

// Returns XYZ over |w|^2 of coordinates in the basis of `piece`, in stored units.
vec3 colour_of(Numbers numbers, Piece piece) {
    vec4 powers = vec4(1.0, piece.t, piece.t * piece.t, piece.t * piece.t * piece.t);
    vec3 sum = vec3(0.0);
    [[unroll]] for (int i = 0; i < 4 * TEXELS; ++i) {
        vec3 colour = vec3(dot(texelFetch(basis, ivec2(3 * i, piece.number), 0), powers),
                           dot(texelFetch(basis, ivec2(3 * i + 1, piece.number), 0), powers),
                           dot(texelFetch(basis, ivec2(3 * i + 2, piece.number), 0), powers));
        sum += numbers.of_texel[i >> 2][i & 3] * colour;
    }
    return sum;
}

float specular_column(float w) {
    float columns = float(textureSize(specular, 0).x);
    return (w / LARGEST_W * (columns - 1.0) + 0.5) / columns;
}

vec3 specular_weight(float column, int row) {
    return textureLod(specular, vec2(column, (float(row) + 0.5) / float(BANDS + 2)), 0.0).rgb;
}

// Returns the factor of f, including the mean R of a material at the pixel's directions.
float table_factor(Pair pair) {
    float mean = specular_weight(specular_column(2.0 * pair.cos_half), BANDS + 1).r;
    return mean * pair.factor / (4.0 * PI);
}

// Returns the specular order: a Gaussian in (u, v) for each band of wavelengths.
vec3 source_specular(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    // Beyond this the widest lobe is negligible: exp(-0.5 * 40) of its peak.
    const float NOWHERE = 40.0;
    float widest = max(c.x, c.z) + source.variances[0].x;
    bool seen = pair.factor > 0.0 && dot(pair.toward, pair.toward) < NOWHERE * widest;
    int bands = seen ? BANDS : 0;
    float column = specular_column(pair.w);
    vec3 sum = vec3(0.0);
    for (int band = 0; band < bands; ++band) {
        float variance = source.variances[band >> 2][band & 3];
        sum += specular_weight(column, band) * normal_density(c + vec3(variance, 0.0, variance), pair.toward);
    }
    return sum * table_factor(pair);
}

// Returns the specular order, integrated over (u, v).
vec3 source_mirrored(Pair pair) {
    return specular_weight(specular_column(pair.w), BANDS) * table_factor(pair);
}

const bool SOURCE_READS_FOOTPRINT = true;

vec3 source_xyz(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    Ellipse ellipse = ellipse_of(c);
    // A level averages over the shorter axis, as far as it is not wider, and taps over the rest.
    float own = max(max(ellipse.shorter, source.finest), least_own(ellipse, source.coherence));
    float level = min(level_of_ratio((own - source.finest) * source.per_growth + 1.0), source.last_level);
    float read = source.finest + (exp2(2.0 * level) - 1.0) / source.per_growth;
    float next = level < source.last_level ? source.finest + (exp2(2.0 * level + 2.0) - 1.0) / source.per_growth : 0.0;
    Taps taps = taps_of(ellipse, own, Levels(read, next, source.coherence));
    Piece piece = piece_of(pair.w);
    vec2 middle = pair.toward * source.texture_per_uv + 0.5;
    float layer = float(TEXELS * piece.number);
    Numbers average = NOTHING;
    // Nothing is read if no light reaches the pixel.
    int rows = pair.factor > 0.0 ? taps.rows : 0;
    for (int number = 0; number < rows; ++number) {
        Row row = row_of(taps, number);
        vec2 step = row.step * source.texture_per_uv;
        vec2 place = middle + row.aside * source.texture_per_uv;
        for (float n = row.first; n < 0.5 - row.first; n += 1.0) {
            add_place(average, row.weight * exp(-row.fall * n * n), vec3(place + n * step, layer), level + row.coarser);
        }
    }
    return colour_of(average, piece) * (source.unit * pair.w * pair.w) * table_factor(pair);
}

// Never used: a table has no single wavelengths.
float source_spectral(Pair pair, float wavenumber) {
    return 0.0;
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(color_table, pixel, scattered, samples);
}
