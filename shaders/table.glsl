// Colour of a pair of directions from a colour table. Texels are coordinates in cubics over pieces of the range of |w|,
// in levels half an octave apart that average over growing Gaussians in (u, v). The specular order is added separately. The CPU twin is
// src/table/read.rs.
//
// The includer defines TEXELS, BANDS, the parameters of the table in `source`, and three functions that read:
//   vec4 table_texel(vec3 place, float mip)     four coordinates at a texture coordinate and layer, linear between texels, 0 outside
//   vec4 table_cubic(int column, int piece)     factors of 1, t, t^2 and t^3 of X, Y and Z of one coordinate after the other
//   vec4 table_row(float place, int row)        XYZ of the specular order at `place`, 0 to 1, and its variance; a row for each of BANDS bands of wavelengths, for the sums of each 4, 16 ... and all of them, and for the mean R

const int MEAN_ROW = (4 * BANDS - 1) / 3; // row of the mean R, below the sums
const float LARGEST_W = 2.0;

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

// Returns the variance of u that a level averages over.
float variance_of_level(float level) {
    return source.finest + (exp2(level) - 1.0) / source.per_growth;
}

// Texels of a level: the mip level, and the first layer of a piece in it.
struct Storage {
    float mip;
    float layer;
};

// Mip level m has the layers of level 2m, and then those of level 2m + 1.
Storage storage_of(float level, Piece piece) {
    float mip = floor(0.5 * level);
    return Storage(mip, float(TEXELS) * ((level - 2.0 * mip) * source.pieces + float(piece.number)));
}

// Adds `weight` times the coordinates at `place`.
void add_place(inout Numbers sum, float weight, vec2 place, Storage storage) {
    UNROLL for (int i = 0; i < TEXELS; ++i) {
        sum.of_texel[i] += weight * table_texel(vec3(place, storage.layer + float(i)), storage.mip);
    }
}

// Returns XYZ over |w|^2 of coordinates in the basis of `piece`, in stored units.
vec3 colour_of(Numbers numbers, Piece piece) {
    vec4 powers = vec4(1.0, piece.t, piece.t * piece.t, piece.t * piece.t * piece.t);
    vec3 sum = vec3(0.0);
    UNROLL for (int i = 0; i < 4 * TEXELS; ++i) {
        vec3 colour = vec3(dot(table_cubic(3 * i, piece.number), powers),
                           dot(table_cubic(3 * i + 1, piece.number), powers),
                           dot(table_cubic(3 * i + 2, piece.number), powers));
        sum += numbers.of_texel[i >> 2][i & 3] * colour;
    }
    return sum;
}

// Returns the factor of f, including the mean R of a material at the pixel's directions.
vec3 table_factor(Pair pair) {
    return table_row(pair.cos_half, MEAN_ROW).r * pair.factor / (4.0 * PI);
}

// Returns the specular order: a Gaussian in (u, v) for each band of wavelengths.
vec3 table_specular(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    // Beyond this the widest lobe is negligible: exp(-0.5 * 40) of its peak.
    const float NOWHERE = 40.0;
    float place = pair.w / LARGEST_W;
    float widest = table_row(place, 0).a;
    bool seen = pair.factor.y > 0.0 && dot(pair.toward, pair.toward) < NOWHERE * (max(c.x, c.z) + widest);
    // Bands differ by their variances, which matter the less the more the footprint averages: sums of 4, 16 and 64 bands of the 64 serve where it has 3, 15 and 63
    // times the variance of a band.
    float narrowest = 0.5 * (c.x + c.z) - length(vec2(0.5 * (c.x - c.z), c.y));
    int first = 0;
    int bands = BANDS;
    for (float room = 4.0; bands > 1 && narrowest + widest > room * widest * 64.0 / float(BANDS); room *= 4.0) {
        first += bands;
        bands /= 4;
    }
    bands = seen ? bands : 0;
    vec3 sum = vec3(0.0);
    for (int band = first; band < first + bands; ++band) {
        vec4 lobe = table_row(place, band);
        sum += lobe.rgb * normal_density(c + vec3(lobe.a, 0.0, lobe.a), pair.toward);
    }
    return sum * table_factor(pair);
}

// Returns XYZ of f cos(theta_i) [1/sr] for coordinates at the pair.
vec3 table_value(Pair pair, Numbers numbers, Piece piece) {
    return colour_of(numbers, piece) * (source.unit * pair.w * pair.w) * table_factor(pair);
}

// Returns XYZ of f cos(theta_i) [1/sr] without the specular order, averaged over the footprint.
vec3 table_scattered(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    Ellipse ellipse = ellipse_of(c);
    // A level averages over the shorter axis, as far as it is not wider, and taps over the rest.
    float across = max(max(ellipse.shorter, source.finest), least_own(ellipse, source.coherence));
    float level = min(level_of_ratio((across - source.finest) * source.per_growth + 1.0), source.last_level);
    float read = variance_of_level(level);
    float next = level < source.last_level ? variance_of_level(level + 1.0) : 0.0;
    Taps taps = taps_of(ellipse, across, Levels(read, next, source.coherence));
    Piece piece = piece_of(pair.w);
    vec2 middle = pair.toward * source.texture_per_uv + 0.5;
    Numbers average = NOTHING;
    // Nothing is read if no light reaches the pixel.
    int rows = pair.factor.y > 0.0 ? taps.rows : 0;
    for (int number = 0; number < rows; ++number) {
        Row row = row_of(taps, number);
        Storage storage = storage_of(level + row.coarser, piece);
        vec2 step = row.step * source.texture_per_uv;
        vec2 place = middle + row.aside * source.texture_per_uv;
        for (float n = row.first; n < 0.5 - row.first; n += 1.0) {
            add_place(average, row.weight * exp(-row.fall * n * n), place + n * step, storage);
        }
    }
    return table_value(pair, average, piece);
}

// Returns XYZ of f cos(theta_i) [1/sr] without the specular order, averaged over a round footprint of this variance, a mixture of two levels. That is no Gaussian, but serves for light
// whose distribution is not known.
vec3 table_round(Pair pair, float variance) {
    variance = max(variance, source.finest);
    float level = min(level_of_ratio((variance - source.finest) * source.per_growth + 1.0), source.last_level);
    float next = min(level + 1.0, source.last_level);
    Levels levels = Levels(variance_of_level(level), variance_of_level(next), source.coherence);
    float share = next > level ? share_between(levels, variance) : 0.0;
    Piece piece = piece_of(pair.w);
    vec2 place = pair.toward * source.texture_per_uv + 0.5;
    Numbers average = NOTHING;
    add_place(average, 1.0 - share, place, storage_of(level, piece));
    add_place(average, share, place, storage_of(next, piece));
    return table_value(pair, average, piece);
}
