#version 460
// Adds a sample of a picture, or a sum of samples, to a sum by blending. A sample has weight for its pixel and for the
// eight neighbours. Alpha counts the samples that cover the pixel. Reads outside the picture are clamped to its edge.

layout(set = 0, binding = 0) uniform sampler2D radiance;

// `PixelWeights` of src/render/sampling.rs: weights of the previous pixel, of this one, and of the next.
layout(push_constant) uniform Weights {
    vec3 across;
    vec3 down;
    ivec2 last; // column and row
} weights;

layout(location = 0) out vec4 added;

vec4 row(int x, int y) {
    int before = max(x - 1, 0), behind = min(x + 1, weights.last.x);
    return weights.across.x * texelFetch(radiance, ivec2(before, y), 0)
        + weights.across.y * texelFetch(radiance, ivec2(x, y), 0)
        + weights.across.z * texelFetch(radiance, ivec2(behind, y), 0);
}

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    added = weights.down.x * row(at.x, max(at.y - 1, 0))
        + weights.down.y * row(at.x, at.y)
        + weights.down.z * row(at.x, min(at.y + 1, weights.last.y));
}
