#version 460
// Adds a sample of covered pixels to those before it, by blending. Alpha counts the samples that the mesh covers.

layout(set = 0, binding = 0) uniform sampler2D radiance; // of the sample

layout(location = 0) out vec4 added;

void main() {
    added = vec4(texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb, 1.0);
}
