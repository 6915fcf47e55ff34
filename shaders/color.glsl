// Colour conversions: the twin of src/optics/color.rs, after IEC 61966-2-1.

#include "linear_srgb.glsl"

const vec3 LUMINANCE = vec3(0.2126390059, 0.7151686788, 0.0721923154);

// Moves a colour toward the grey of the same luminance until it is in gamut: hue stays, saturation decreases.
vec3 map_to_gamut(vec3 rgb) {
    float grey = clamp(dot(LUMINANCE, rgb), 0.0, 1.0);
    vec3 away = rgb - grey;
    vec3 room = mix(vec3(grey), vec3(1.0 - grey), greaterThan(away, vec3(0.0)));
    // A component that does not move limits nothing; the lower bound avoids 0/0.
    vec3 reach = room / max(abs(away), vec3(1e-30));
    return clamp(grey + away * min(1.0, min(reach.x, min(reach.y, reach.z))), 0.0, 1.0);
}

// Moves a colour toward the grey of the same luminance until no component is negative.
vec3 without_negatives(vec3 rgb) {
    float least = min(rgb.r, min(rgb.g, rgb.b));
    if (least >= 0.0) {
        return rgb;
    }
    float grey = max(dot(LUMINANCE, rgb), 0.0);
    return max(mix(vec3(grey), rgb, grey / (grey - least)), 0.0);
}

// The Khronos PBR Neutral Tone Mapper (Khronos Group, 2024): hue stays, and highlights tend smoothly to white.
vec3 neutral(vec3 rgb) {
    const float FRESNEL = 0.04;
    const float START = 0.8 - FRESNEL;
    const float DESATURATION = 0.15;
    const float ROOM = 1.0 - START;
    rgb = without_negatives(rgb);
    float least = min(rgb.r, min(rgb.g, rgb.b));
    rgb = max(rgb - (least < 2.0 * FRESNEL ? least - least * least / (4.0 * FRESNEL) : FRESNEL), 0.0);
    float peak = max(rgb.r, max(rgb.g, rgb.b));
    if (peak < START) {
        return rgb;
    }
    float compressed = 1.0 - ROOM * ROOM / (peak + ROOM - START);
    float white = 1.0 - 1.0 / (DESATURATION * (peak - compressed) + 1.0);
    return mix(rgb * (compressed / peak), vec3(compressed), white);
}

vec3 srgb_transfer(vec3 linear) {
    return mix(1.055 * pow(linear, vec3(1.0 / 2.4)) - 0.055, 12.92 * linear, lessThanEqual(linear, vec3(0.0031308)));
}

// Returns codes of an 8-bit display, divided by 255. They are rounded here, because devices may write 8 bits through
// 16-bit floats and round to an adjacent code.
vec3 srgb_codes(vec3 linear) {
    return round(255.0 * srgb_transfer(linear)) / 255.0;
}
