#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the directions of a light at each covered pixel, exactly as shading computes them, for a reference that shades
// the very same directions. The twin is `Directions` of src/render/directions.rs.
#include "frame.glsl"
#include "brdf.glsl"
#include "gbuffer.glsl"
#include "light.glsl"

layout(push_constant) uniform Directions {
    int place; // of the light
};

layout(location = 0) out vec4 to_light;  // in the frame of the patch; from straight below in shadow. w: falloff of a lamp, times the share of the light that is visible
layout(location = 1) out vec4 footprint; // du/dx, dv/dx, du/dy, dv/dy
layout(location = 2) out vec4 mirrored;  // radiance of the surroundings

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    SurfacePoint at = surface_at(pixel);
    int number = CHOSEN ? slot_of(pixel, place) : place;
    Light light = frame.lights[number];
    mat2x3 views = view_differences(at);
    vec3 direction = direction_of_light(at, light);
    Footprint change = footprint_of(at, views, light, direction);
    float share = SHADOWS ? visibility(at, light, number) : 1.0;
    to_light = vec4(share > 0.0 ? direction : vec3(0.0, 0.0, -1.0), share * falloff(at, light));
    footprint = vec4(change.dx, change.dy);
    mirrored = vec4(MIRRORED ? mirrored_radiance(at, views, light) : vec3(0.0), 1.0);
}
