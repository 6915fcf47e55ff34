#version 460
#extension GL_GOOGLE_include_directive : require
// Writes what a covered pixel has to be shaded with: directions in its tangent frame, the pigment, and footprints. Shading follows in a
// pass of its own, pixel beside pixel, whatever the size of the triangles; a reference shades the very same directions.
#include "frame.glsl"

layout(set = 0, binding = 1) uniform sampler2D pigment;

layout(constant_id = 0) const int LIGHTS = MAX_LIGHTS; // of the scene
layout(constant_id = 1) const bool TEXTURED = true;    // whether the pigment is of a texture
layout(constant_id = 2) const bool FOOTPRINTS = true;  // whether footprints are asked for

layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 lights[MAX_LIGHTS];

// As `pixel.glsl` reads them. The attachments of a pass have no gaps: where footprints are asked for, they stand between the others, those
// of a light behind the first image that a picture of so many lights has in any case. Images that a picture does not have are dropped.
layout(location = 0) out vec4 directions;
layout(location = 1) out vec4 image_1; // footprint of the first light,  or albedo
layout(location = 2) out vec4 image_2; // albedo,                        or the second and the third light
layout(location = 3) out vec4 image_3; // the second and the third light, or the fourth
layout(location = 4) out vec4 image_4; // footprint of the second light
layout(location = 5) out vec4 image_5; // footprint of the third light
layout(location = 6) out vec4 image_6; // the fourth light
layout(location = 7) out vec4 image_7; // footprint of the fourth light

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

// How (u, v) changes from pixel to pixel: du/dx, dv/dx, du/dy, dv/dy. Differences within the triangle, also beside its edges, where a
// neighbour that it does not cover is extrapolated. u and v of unit vectors are within -2 ... 2, so that no difference exceeds 4;
// extrapolated beyond the viewer there may be no number, and then there is no footprint.
vec4 footprint(int light) {
    if (light >= LIGHTS) {
        return vec4(0.0);
    }
    vec2 uv = -(normalize(lights[light]).xy + normalize(view).xy);
    vec4 change = vec4(dFdxFine(uv), dFdyFine(uv));
    return any(isnan(change)) || any(isinf(change)) ? vec4(0.0) : change;
}

void main() {
    directions = vec4(projected(view), projected_light(0));
    vec4 more_lights_0 = vec4(projected_light(1), projected_light(2));
    vec4 more_lights_1 = vec4(projected_light(3), 0.0, 0.0);
    vec4 albedo = vec4(frame.base_color.rgb, 1.0);
    if (TEXTURED && frame.base_color.w > 0.0) {
        albedo.rgb *= texture(pigment, pigment_uv).rgb;
    }
    if (FOOTPRINTS) {
        image_1 = footprint(0);
        image_2 = albedo;
        image_3 = more_lights_0;
        image_4 = footprint(1);
        image_5 = footprint(2);
        image_6 = more_lights_1;
        image_7 = footprint(3);
    } else {
        image_1 = albedo;
        image_2 = more_lights_0;
        image_3 = more_lights_1;
        image_4 = image_5 = image_6 = image_7 = vec4(0.0);
    }
}
