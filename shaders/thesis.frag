#version 460
#extension GL_GOOGLE_include_directive : require
// What the thesis' own shader sums [Single 2014]: for each wavelength and each term of the Taylor series, the Fourier series of the
// endless surface at the 3 x 3 bins nearest to a frequency, weighted by the spectrum of the window. For comparison only. Kinder than
// the original where that does not change the sum: two terms share a texel, and weights are made once a wavelength.
#include "interface.glsl"
#include "spectrum.glsl"
#include "diffraction.glsl"
#include "color.glsl"
#include "pixel.glsl"

layout(push_constant) uniform Thesis {
    float half_range; // a: the heights are in -a ... a [um]
} thesis;

layout(location = 0) out vec4 radiance; // linear sRGB, signed; alpha: covered

// |P|^2 relative to the flat mirror's peak.
float power_of_taps(Pair pair, float wavenumber) {
    vec2 place = pair.toward * wavenumber * optics.texels_per_frequency; // bins
    vec2 nearest = floor(place + 0.5);
    ivec2 middle = ivec2(nearest + optics.origin);
    // The window's spectrum, exp(-2 pi^2 sigma^2 f^2), at the bins on either side and in the middle.
    vec2 width = 2.0 * PI * PI * optics.sigma * optics.sigma / (optics.texels_per_frequency * optics.texels_per_frequency);
    vec2 weights[3];
    for (int tap = 0; tap < 3; ++tap) {
        vec2 away = place - nearest - float(tap - 1);
        weights[tap] = exp(-width * away * away);
    }
    float step = 2.0 * PI * wavenumber * pair.w * thesis.half_range;
    vec2 c = vec2(1.0, 0.0); // (i z a)^n / n!
    vec2 p = vec2(0.0);
    for (int layer = 0; layer < PAIRS; ++layer) {
        float n = float(2 * layer + 1);
        vec2 next = vec2(-c.y, c.x) * (step / n);
        vec4 s = vec4(0.0);
        for (int y = 0; y < 3; ++y) {
            for (int x = 0; x < 3; ++x) {
                s += weights[x].x * weights[y].y * texelFetch(layers, ivec3(middle + ivec2(x - 1, y - 1), layer), 0);
            }
        }
        p += sum_of_terms(vec4(c.x, c.y * pair.conjugate, next.x, next.y * pair.conjugate), s);
        c = vec2(-next.y, next.x) * (step / (n + 1.0));
    }
    return dot(p, p);
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stored = texelFetch(directions, pixel, 0);
    radiance = vec4(0.0, 0.0, 0.0, covered(stored) ? 1.0 : 0.0);
    if (!covered(stored)) {
        return;
    }
    vec3 to_view = unprojected(stored.xy);
    vec3 albedo = albedo_of(pixel);
    for (int i = 0; i < frame.counts.x; ++i) {
        vec3 to_light = light_direction(stored, i, pixel);
        Pair pair = pair_of(to_light, to_view);
        if (pair.factor == 0.0) {
            continue;
        }
        float largest = largest_wavenumber(pair);
        vec3 xyz = vec3(0.0);
        for (int node = 0; node < combs[0].y; ++node) {
            vec4 weight_and_wavenumber = texelFetch(nodes, ivec2(node, combs[0].x), 0);
            float wavenumber = weight_and_wavenumber.w;
            if (wavenumber > largest) {
                break; // wavenumbers grow
            }
            xyz += weight_and_wavenumber.xyz * (wavenumber * wavenumber * power_of_taps(pair, wavenumber));
        }
        vec3 diffracted = LINEAR_SRGB_FROM_XYZ * xyz * pair.factor;
        vec3 pigmented = albedo * ((1.0 - pair.reflectance) * to_light.z / PI);
        radiance.rgb += (diffracted + pigmented) * (frame.lights[i].w * PI);
    }
}
