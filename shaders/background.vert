#version 460
#extension GL_GOOGLE_include_directive : require
// Draws one triangle that covers the target at the clear depth, with the view directions.
#include "frame.glsl"

layout(location = 0) out vec3 toward; // from the viewer, in world space; not normalised

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0;
    gl_Position = vec4(corner * 2.0 - 1.0, 1.0, 1.0);
    // The block is that of one sample; the background is seen at the pixel centres.
    vec2 moved = -frame.grooves.zw * frame.at.jitter;
    vec4 far = inverse(frame.clip_from_world) * (gl_Position + vec4(moved, 0.0, 0.0));
    toward = -toward_viewer(far.xyz / far.w);
}
