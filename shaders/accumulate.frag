#version 460
// Adds samples to those before them, by blending. Alpha counts the samples that the mesh covers.

layout(set = 0, binding = 0) uniform sampler2D radiance; // of the samples

layout(location = 0) out vec4 added;

void main() {
    added = texelFetch(radiance, ivec2(gl_FragCoord.xy), 0);
}
