#version 460
#extension GL_GOOGLE_include_directive : require
// Draws the mesh as the light sees it: depth alone.
#include "frame.glsl"

layout(location = 0) in vec3 position;

void main() {
    gl_Position = frame.shadow_from_world * vec4(position, 1.0);
}
