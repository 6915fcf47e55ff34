// Display of linear radiance: exposure, then tone mapping or gamut mapping. Its twin is `Shown` of src/render/frame.rs.
#include "color.glsl"

layout(push_constant) uniform Display {
    vec3 background; // linear
    float exposure;  // in stops
    float samples;   // number in the sum
    uint neutral;    // 1 for the neutral tone, 0 for none
} display;

vec3 displayed(vec3 radiance) {
    vec3 exposed = radiance * exp2(display.exposure);
    if (display.neutral != 0u) {
        return neutral(exposed);
    }
    return map_to_gamut(exposed);
}
