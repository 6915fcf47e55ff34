#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the depth of the mesh from a light. The number of the instance is that of the light.
#include "frame.glsl"

layout(location = 0) in vec3 position;

void main() {
    gl_Position = frame.lights[gl_InstanceIndex].shadow_from_world * vec4(position, 1.0);
}
