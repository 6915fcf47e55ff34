// Reads a colour table: the mean over coherence areas, summed over the spectrum, as cubics in |w| over -(u, v), in levels that average over
// growing Gaussians of (u, v). Its CPU twin is src/table/read.rs; the Rust side is src/render/source/table.rs.
#include "footprint.glsl"

// X, Y and Z of piece after piece of the range of |w|; RGBA: the coefficients of a cubic.
layout(set = 1, binding = 1) uniform sampler2DArray color_table;

// XYZ of the specular order over |w|, a band of wavelengths a row, and then all bands together; in the last row the mean R of a material over twice
// the cosine of the half angle, or 1.
layout(set = 1, binding = 2) uniform sampler2D specular;

const int BANDS = 16;       // of wavelengths of the specular order
const float LARGEST_W = 2.0;

layout(set = 1, binding = 0, std140) uniform Table {
    float normal_reflectance; // R0 of Schlick, or 1
    float texture_per_uv;     // texture coordinate per unit of u
    float coherence;          // variance of u that coherence averages over
    float unit;               // what a stored 1 stands for [1/sr]
    float finest;             // variance of u that the finest level averages over
    float per_growth;         // 1 over the variance by which levels grow
    float pieces;             // of 0 ... LARGEST_W
    float last_level;
    vec4 variances[BANDS / 4]; // of u in each band of the specular order
} source;

struct Piece {
    float layer;
    vec4 powers;
};

Piece piece_of(float w) {
    float place = w * (source.pieces / LARGEST_W);
    float number = min(floor(place), source.pieces - 1.0);
    float t = 2.0 * (place - number) - 1.0;
    return Piece(3.0 * number, vec4(1.0, t, t * t, t * t * t));
}

vec3 read_table(Piece piece, vec2 place, float level) {
    return vec3(dot(textureLod(color_table, vec3(place, piece.layer), level), piece.powers),
                dot(textureLod(color_table, vec3(place, piece.layer + 1.0), level), piece.powers),
                dot(textureLod(color_table, vec3(place, piece.layer + 2.0), level), piece.powers));
}

float specular_column(float w) {
    float columns = float(textureSize(specular, 0).x);
    return (w / LARGEST_W * (columns - 1.0) + 0.5) / columns;
}

vec3 specular_weight(float column, int row) {
    return textureLod(specular, vec2(column, (float(row) + 0.5) / float(BANDS + 2)), 0.0).rgb;
}

// What stands before f: the mean R of a material is that at the pixel's own directions.
float table_factor(Pair pair) {
    float mean = specular_weight(specular_column(2.0 * pair.cos_half), BANDS + 1).r;
    return mean * pair.factor / (4.0 * PI);
}

// The specular order: a Gaussian of (u, v) for each band of wavelengths.
vec3 source_specular(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    // The widest lobe is nowhere else: exp(-0.5 * 40) of its peak.
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

// The specular order of all (u, v).
vec3 source_mirrored(Pair pair) {
    return specular_weight(specular_column(pair.w), BANDS) * table_factor(pair);
}

const bool SOURCE_READS_FOOTPRINT = true;

vec3 source_xyz(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    Ellipse ellipse = ellipse_of(c);
    // A level stands for the shorter axis, as far as it averages over no more, and taps for the rest.
    float own = max(max(ellipse.shorter, source.finest), least_own(ellipse, source.coherence));
    float level = min(level_of_ratio((own - source.finest) * source.per_growth + 1.0), source.last_level);
    float read = source.finest + (exp2(2.0 * level) - 1.0) / source.per_growth;
    float next = level < source.last_level ? source.finest + (exp2(2.0 * level + 2.0) - 1.0) / source.per_growth : 0.0;
    Taps taps = taps_of(ellipse, own, Levels(read, next, source.coherence));
    Piece piece = piece_of(pair.w);
    vec2 middle = pair.toward * source.texture_per_uv + 0.5;
    vec3 average = vec3(0.0);
    // Nothing is read for light that does not reach the pixel.
    int rows = pair.factor > 0.0 ? taps.rows : 0;
    for (int number = 0; number < rows; ++number) {
        Row row = row_of(taps, number);
        vec2 step = row.step * source.texture_per_uv;
        vec2 place = middle + row.aside * source.texture_per_uv;
        vec3 sum = vec3(0.0);
        float norm = 0.0;
        for (float n = row.first; n < row.last; n += 1.0) {
            float weight = exp(-row.fall * n * n);
            sum += weight * read_table(piece, place + n * step, level + row.coarser);
            norm += weight;
        }
        average += sum * (row.weight / norm);
    }
    return average * (source.unit * pair.w * pair.w) * table_factor(pair);
}

// A table has no single wavelength; nobody asks.
float source_spectral(Pair pair, float wavenumber) {
    return 0.0;
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(color_table, pixel, scattered, samples);
}
