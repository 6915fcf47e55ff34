// The window: spectra of an expansion's terms through one Gaussian window, summed over wavelengths. Its twin is
// src/render/source/window.rs.
#include "spectra.glsl"

const int UV_BINS = 256; // entries of `combs` over |(u, v)| in 0 ... 2

// Wavelength combs: row of `nodes` and number of nodes for each bin of |(u, v)|.
layout(set = 1, binding = 4, std430) readonly buffer Combs { ivec2 combs[]; };

#include "lines.glsl"

const bool SOURCE_READS_FOOTPRINT = false;

// XYZ of f cos(theta_i) [1/sr], over the wavelengths that are in the band: where the ray crosses lines, or, where there are none, by the
// comb that |(u, v)| needs.
vec3 source_xyz(Pair pair, Footprint footprint) {
    Ray ray = ray_of(pair);
    float largest = largest_wavenumber(pair);
    if (LINES) {
        return cosine_weighted(pair, sum_over_lines(ray, largest));
    }
    vec3 xyz = vec3(0.0);
    ivec2 comb = combs[min(int(pair.uv * (0.5 * float(UV_BINS))), UV_BINS - 1)];
    for (int node = 0; node < comb.y; ++node) {
        vec4 weight_and_wavenumber = texelFetch(nodes, ivec2(node, comb.x), 0);
        float wavenumber = weight_and_wavenumber.w;
        if (wavenumber > largest) {
            break; // wavenumbers grow
        }
        xyz += weight_and_wavenumber.xyz * (wavenumber * wavenumber * power(ray, wavenumber));
    }
    return cosine_weighted(pair, xyz);
}

float source_spectral(Pair pair, float wavenumber) {
    return cosine_weighted_at(pair, wavenumber);
}

// The sum of `samples` reads of the texture, one after the other.
vec4 source_reads(vec2 pixel, bool scattered, int samples) {
    if (!LINES) {
        return reads_of(layers, pixel, scattered, samples);
    }
    // As the frame reads them: neighbours along a line, pair beside pair.
    vec4 sum = vec4(0.0);
    ivec3 size = PACKED ? textureSize(packed_lines, 0) * ivec3(2, 1, 1) : textureSize(lines, 0);
    ivec2 points = size.xy / ivec2(GROUPED, 1) - 4;
    vec2 from = scattered ? elsewhere(uvec2(pixel)) * vec2(points) : pixel;
    ivec2 at = ivec2(mod(from, vec2(points))) + 2;
    float t = fract(pixel.x * 0.25);
    int pair = 0, layer = 0;
    for (int i = 0; i < samples; ++i) {
        if (PACKED) {
            TwoPairs two = read_two_pairs(ivec3((at.x * GROUPED + pair) / 2, at.y, layer), t);
            sum += two.first + two.second;
            pair += 2;
            ++i;
        } else {
            sum += read_line(ivec3(at.x * GROUPED + pair, at.y, layer), t);
            pair += 1;
        }
        if (pair == GROUPED) {
            pair = 0;
            layer += 1;
            if (layer == size.z) {
                layer = 0;
                at.y = at.y < points.y ? at.y + 1 : 2;
            }
        }
    }
    return sum;
}
