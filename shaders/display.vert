#version 460
// Draws one triangle that covers the target at the clear depth.

void main() {
    vec2 corner = vec2(gl_VertexIndex & 1, gl_VertexIndex >> 1) * 2.0;
    gl_Position = vec4(corner * 2.0 - 1.0, 1.0, 1.0);
}
