#version 460
#extension GL_GOOGLE_include_directive : require
// Writes what a covered pixel has to be shaded with: directions in its tangent frame, and the pigment. Shading follows in a
// pass of its own, pixel beside pixel, whatever the size of the triangles; a reference shades the very same directions.
#include "frame.glsl"

layout(set = 0, binding = 1) uniform sampler2D pigment;

layout(constant_id = 0) const int LIGHTS = MAX_LIGHTS; // of the scene
layout(constant_id = 1) const bool TEXTURED = true;    // whether the pigment is of a texture

layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 lights[MAX_LIGHTS];

// As `pixel.glsl` reads them.
layout(location = 0) out vec4 directions;
layout(location = 1) out vec4 albedo; // linear sRGB
layout(location = 2) out vec4 more_lights_0;
layout(location = 3) out vec4 more_lights_1;

// Stereographic from -N. Near there the direction is far below the horizon, and which one it is does not matter.
vec2 projected(vec3 direction) {
    const float LEAST = 0.1;
    float size = length(direction);
    float depth = size + direction.z;
    return depth > LEAST * size ? direction.xy / depth : vec2(1.0 / LEAST, 0.0);
}

vec2 projected_light(int light) {
    return light < LIGHTS ? projected(lights[light]) : vec2(0.0);
}

void main() {
    directions = vec4(projected(view), projected_light(0));
    more_lights_0 = vec4(projected_light(1), projected_light(2));
    more_lights_1 = vec4(projected_light(3), 0.0, 0.0);
    albedo = vec4(frame.base_color.rgb, 1.0);
    if (TEXTURED && frame.base_color.w > 0.0) {
        albedo.rgb *= texture(pigment, pigment_uv).rgb;
    }
}
