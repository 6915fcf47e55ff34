// Sums wavelengths over power spectra: the mean over coherence areas. A texel holds four terms of a Chebyshev series in z = k|w| of
// the powers of the orders over z^2, blurred by the coherence of the light; coarser levels have twice the blur each.
// The CPU twin is src/spectra/power/read.rs; the Rust side is src/render/source/mean.rs.
#extension GL_EXT_control_flow_attributes : require
#include "footprint.glsl"
#include "kernel.glsl"
#define REFLECTANCE_BINDING 5
#include "reflectance.glsl"

layout(constant_id = 11) const int LAYERS = 3; // four terms each

layout(set = 1, binding = 0, std140) uniform Mean {
    vec2 texels;             // of the finest level
    vec2 range;              // of frequencies that the texture covers, 0 in its middle [1/um]
    vec2 band;               // largest |f_x|, |f_y| that the samples hold [1/um]
    float normal_reflectance; // R0 of Schlick
    float x_per_z;           // 2 over the largest z [um]
    float unit;              // what a stored 1 stands for [um^4]
    float orders;            // variance of an order's blur by coherence over that of the finest level
    float finest;            // variance of the finest level's blur [1/um^2]
    float specular;          // variance of the specular order [1/um^2]
    float last_level;
    float rays;              // |(u, v)| of a comb's bin per unit of |(u, v)| over the blur at `middle`
    float middle;            // squared wavenumber in the middle of the spectrum [1/um^2]
    float blur;              // least variance of u that the finest level averages over: of blue light
} source;

layout(set = 1, binding = 1) uniform sampler2DArray powers;

// |c_0|^2 of the specular order over z, 0 ... the largest.
layout(set = 1, binding = 2) uniform sampler2D specular;

// XYZ weight and wavenumber 1/lambda [1/um] of nodes, the wavenumber growing along a row.
layout(set = 1, binding = 3) uniform sampler2D nodes;

// Row and number of nodes for each bin of |(u, v)|.
layout(set = 1, binding = 4, std430) readonly buffer Combs { ivec2 combs[]; };
const int UV_BINS = 256; // over |(u, v)| in 0 ... 2

// Sum of the orders' powers over z^2 near frequency `f`, in stored units.
float fluctuation(vec2 f, float z, float level) {
    vec2 place = f / source.range + 0.5;
    float x = z * source.x_per_z - 1.0;
    vec4 t = vec4(1.0, x, 2.0 * x * x - 1.0, (4.0 * x * x - 3.0) * x);
    // T_k+4 and T_k+5 ... from T_k and T_4: T_m+4 = 2 T_4 T_m - T_|m-4|.
    float twice_four = 2.0 * (2.0 * t.z * t.z - 1.0);
    vec4 before = vec4(2.0 * t.z * t.z - 1.0, t.w, t.z, t.y); // T_4, T_3, T_2, T_1: of -4 ... -1
    vec2 size = source.texels * exp2(-level);
    Read read = read_at(place * size, size);
    float sum = 0.0;
    [[unroll]] for (int layer = 0; layer < LAYERS; ++layer) {
        sum += dot(read_layer(powers, read, layer, level), t);
        vec4 next = twice_four * t - before;
        before = t;
        t = next;
    }
    return max(sum, 0.0);
}

bool held(vec2 f) {
    return all(lessThanEqual(abs(f), source.band));
}

// |c_0|^2 at wavenumber q.
float specular_power(Pair pair, float q) {
    float z = 2.0 * PI * q * pair.w;
    float columns = float(textureSize(specular, 0).x);
    return textureLod(specular, vec2((0.5 * z * source.x_per_z * (columns - 1.0) + 0.5) / columns, 0.5), 0.0).r;
}

// q^2 |P|^2/A of the specular order at wavenumber q.
float specular_density(Pair pair, float q, vec3 c) {
    float variance = source.specular / (q * q);
    return specular_power(pair, q) * normal_density(c + vec3(variance, 0.0, variance), pair.toward);
}

// q^2 <|P|^2>/A of the orders near frequency `f` at one wavenumber: f cos(theta_i) over the pair's factor of B.12.
float mean_power(Pair pair, vec2 f, float q, float level) {
    float z = 2.0 * PI * q * pair.w;
    return held(f) ? q * q * z * z * source.unit * fluctuation(f, z, level) : 0.0;
}

// The same averaged over a blur of `ratio` times the finest level's variance. Between two levels, a
// mixture of both stands for it.
float averaged_power(Pair pair, vec2 toward, float q, float ratio) {
    vec2 f = toward * q;
    float level = min(level_of_ratio(ratio), source.last_level);
    // The place between the levels, by variance: 0 ... 1.
    float s = level < source.last_level ? (ratio * exp2(-2.0 * level) - 1.0) / 3.0 : 0.0;
    if (s <= 0.0) {
        return mean_power(pair, f, q, level);
    }
    return mix(mean_power(pair, f, q, level), mean_power(pair, f, q, level + 1.0), s);
}

// The comb of wavelengths for |(u, v)| in units of the blur.
ivec2 comb_of(float uv) {
    return combs[min(int(uv * (0.5 * float(UV_BINS))), UV_BINS - 1)];
}

// The blur along the ray, of a footprint of which a level has the variance `own`, sets how many wavelengths resolve it.
float rays_of(float own) {
    return source.rays * inversesqrt(source.finest * source.orders + source.middle * own);
}

// The sum over wavelengths at one tap, which averages over the variance `own`.
vec3 colour_at(Pair pair, vec2 toward, float rays, float own) {
    ivec2 comb = comb_of(length(toward) * rays);
    vec3 colour = vec3(0.0);
    for (int j = part.first; j < comb.y; j += part.step) {
        vec4 node = texelFetch(nodes, ivec2(j, comb.x), 0);
        float q = node.w;
        float ratio = source.orders + q * q * own / source.finest;
        colour += node.rgb * (reflectance_at(pair, q) * averaged_power(pair, toward, q, ratio));
    }
    return colour;
}

const bool SOURCE_READS_FOOTPRINT = true;

vec3 source_xyz(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    Ellipse ellipse = ellipse_of(c);
    float own = max(ellipse.shorter, least_own(ellipse, source.blur));
    // What the levels of a wavelength in the middle average over.
    float coarsest = (exp2(2.0 * source.last_level) - source.orders) * source.finest / source.middle;
    float read = clamp(coarsest, 0.0, own);
    Taps taps = taps_of(ellipse, own, Levels(read, 0.0, source.blur));
    float rays = rays_of(read);
    vec3 average = vec3(0.0);
    // Nothing is read for light that does not reach the pixel.
    int rows = pair.factor > 0.0 ? taps.rows : 0;
    for (int number = 0; number < rows; ++number) {
        Row row = row_of(taps, number);
        for (float n = row.first; n < 0.5 - row.first; n += 1.0) {
            vec3 colour = colour_at(pair, pair.toward + row.aside + n * row.step, rays, own);
            average += row.weight * exp(-row.fall * n * n) * colour;
        }
    }
    return average * (pair.factor / (4.0 * PI));
}

// The specular order, in closed form over the whole footprint.
vec3 source_specular(Pair pair, Footprint footprint) {
    vec3 c = covariance(footprint);
    Ellipse ellipse = ellipse_of(c);
    float own = max(ellipse.shorter, least_own(ellipse, source.blur));
    ivec2 comb = comb_of(pair.uv * rays_of(own));
    int count = pair.factor > 0.0 ? comb.y : 0;
    vec3 sum = vec3(0.0);
    for (int j = part.first; j < count; j += part.step) {
        vec4 node = texelFetch(nodes, ivec2(j, comb.x), 0);
        sum += node.rgb * reflectance_at(pair, node.w) * specular_density(pair, node.w, c);
    }
    return sum * (pair.factor / (4.0 * PI));
}

// The specular order of all (u, v).
vec3 source_mirrored(Pair pair) {
    ivec2 comb = comb_of(0.0);
    vec3 sum = vec3(0.0);
    for (int j = part.first; j < comb.y; j += part.step) {
        vec4 node = texelFetch(nodes, ivec2(j, comb.x), 0);
        sum += node.rgb * reflectance_at(pair, node.w) * specular_power(pair, node.w);
    }
    return sum * (pair.factor / (4.0 * PI));
}

float source_spectral(Pair pair, float wavenumber) {
    float q = wavenumber;
    vec3 none = vec3(0.0);
    float power = mean_power(pair, pair.toward * q, q, 0.0) + specular_density(pair, q, none);
    return held(pair.toward * q) ? pair.factor / (4.0 * PI) * reflectance_at(pair, q) * power : 0.0;
}

vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    return reads_of(powers, pixel, scattered, samples);
}
