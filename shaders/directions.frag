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

layout(location = 0) out vec4 to_light;  // in the frame of the patch; from below in shadow. w: falloff of a lamp
layout(location = 1) out vec4 footprint; // du/dx, dv/dx, du/dy, dv/dy
layout(location = 2) out vec4 mirrored;  // radiance of the surroundings

void main() {
    SurfacePoint at = surface_at(ivec2(gl_FragCoord.xy));
    Light light = frame.lights[place];
    mat2x3 views = view_differences(at);
    vec3 direction = direction_of_light(at, light);
    Footprint change = footprint_of(at, views, light, direction);
    to_light = vec4(SHADOWS && in_shadow(at, light, place) ? vec3(0.0, 0.0, -1.0) : direction, falloff(at, light));
    footprint = vec4(change.dx, change.dy);
    mirrored = vec4(MIRRORED ? mirrored_radiance(at, views, light) : vec3(0.0), 1.0);
}
