#version 460
#extension GL_GOOGLE_include_directive : require
// What real-time shaders of compact discs do instead (Stam, in GPU Gems, chapter 8): the surface as a grating of one period, the
// grating equation u = m lambda/d solved for the wavelength of each order, and that wavelength's colour. For comparison only.
#include "interface.glsl"
#include "color.glsl"
#include "pixel.glsl"

layout(push_constant) uniform Grating {
    vec2 axis;      // along which the heights repeat, in the tangent plane
    float period;   // [um]
    float strength; // radiance of the first order
} grating;

layout(location = 0) out vec4 radiance;

const float PI = 3.14159265358979;
const int ORDERS = 8;

float lobe(float x, float centre, float below, float above) {
    float t = (x - centre) / (x < centre ? below : above);
    return exp(-0.5 * t * t);
}

// CIE 1931 2 degree observer at a wavelength in nm (Wyman, Sloan, Shirley 2013, multi-lobe fit).
vec3 observer(float x) {
    return vec3(1.056 * lobe(x, 599.8, 37.9, 31.0) + 0.362 * lobe(x, 442.0, 16.0, 26.7) - 0.065 * lobe(x, 501.1, 20.4, 26.2),
                0.821 * lobe(x, 568.8, 46.9, 40.5) + 0.286 * lobe(x, 530.9, 16.3, 31.1),
                1.217 * lobe(x, 437.0, 11.8, 36.0) + 0.681 * lobe(x, 459.0, 26.0, 13.8));
}

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 stored = texelFetch(directions, pixel, 0);
    radiance = vec4(0.0, 0.0, 0.0, covered(stored) ? 1.0 : 0.0);
    if (!covered(stored)) {
        return;
    }
    vec3 to_view = unprojected(stored.xy), to_light = unprojected(stored.zw);
    vec3 albedo = albedo_of(pixel);
    if (to_light.z <= 0.0 || to_view.z <= 0.0) {
        return;
    }
    float sines = abs(dot(to_light.xy + to_view.xy, grating.axis));
    vec3 xyz = vec3(0.0);
    for (int order = 1; order <= ORDERS; ++order) {
        float wavelength = 1000.0 * grating.period * sines / float(order);
        xyz += observer(wavelength) / float(order * order);
    }
    radiance.rgb = (LINEAR_SRGB_FROM_XYZ * xyz * grating.strength
                    + albedo * ((1.0 - optics.normal_reflectance) * to_light.z / PI)) * (frame.lights[0].w * PI);
}
