#version 460
#extension GL_GOOGLE_include_directive : require
// Writes what a covered pixel has to be shaded with: directions in its tangent frame, and the pigment. Shading follows in a
// pass of its own, pixel beside pixel, whatever the size of the triangles; a reference shades the very same directions.
#include "interface.glsl"

layout(constant_id = 0) const int LIGHTS = MAX_LIGHTS; // of the scene

layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 lights[MAX_LIGHTS];

layout(location = 0) out vec4 to_view;              // w: covered
layout(location = 1) out vec4 albedo;               // linear sRGB
layout(location = 2) out vec4 to_light[MAX_LIGHTS];

void main() {
    to_view = vec4(normalize(view), 1.0);
    albedo = vec4(frame.base_color.rgb, 1.0);
    if (frame.base_color.w > 0.0) {
        albedo.rgb *= texture(pigment, pigment_uv).rgb;
    }
    for (int i = 0; i < LIGHTS; ++i) {
        to_light[i] = vec4(normalize(lights[i]), 1.0);
    }
}
