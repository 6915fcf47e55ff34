// Interpolation in an array texture. The f64 twin, with error bounds, is src/spectra/amplitude/kernel.rs.

layout(constant_id = 40) const bool CUBIC_X = false; // cubic B-spline along x, else linear
layout(constant_id = 41) const bool CUBIC_Y = false; // the same along y
// True if the shader weights each texel. Sampler reads are fewer, but round the weights to 1/256.
layout(constant_id = 42) const bool WEIGHS_TEXELS = false;

// Position and weights of a read, the same for all layers.
struct Read {
    // By a sampler:
    vec2 near;      // texture coordinates of its reads
    vec2 far;
    vec2 far_share; // weight of `far` along each axis with a cubic kernel
    // By texels:
    ivec2 first;    // the first of four along each axis
    vec4 across;    // weights along x
    vec4 up;        // and y
};

// Returns the weights of the four texels around a position, `t` from 0 to 1 between the middle two (cubic B-spline).
vec4 spline_weights(float t) {
    float t2 = t * t, t3 = t2 * t;
    float w0 = (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0;
    float w1 = (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0;
    float w3 = t3 / 6.0;
    return vec4(w0, w1, 1.0 - w0 - w1 - w3, w3);
}

// Returns a cubic B-spline along an axis as two linear samples (Sigg & Hadwiger, GPU Gems 2, chapter 20): each lies
// between two texels where the sampler's linear weights have the ratio of the spline's. x, y: positions of the samples
// [texels]; z: weight of y.
vec3 spline_samples(float texel) {
    float whole = floor(texel - 0.5);
    vec4 w = spline_weights(texel - 0.5 - whole);
    return vec3(whole - 0.5 + w.y / (w.x + w.y), whole + 1.5 + w.w / (w.z + w.w), w.z + w.w);
}

// Returns the read at `place` [texels from the corner] of a level of `size` texels.
Read read_at(vec2 place, vec2 size) {
    Read read;
    if (WEIGHS_TEXELS) {
        vec2 whole = floor(place - 0.5), t = place - 0.5 - whole;
        read.first = ivec2(whole) - 1;
        read.across = CUBIC_X ? spline_weights(t.x) : vec4(0.0, 1.0 - t.x, t.x, 0.0);
        read.up = CUBIC_Y ? spline_weights(t.y) : vec4(0.0, 1.0 - t.y, t.y, 0.0);
    } else {
        vec3 x = CUBIC_X ? spline_samples(place.x) : vec3(place.x, place.x, 0.0);
        vec3 y = CUBIC_Y ? spline_samples(place.y) : vec3(place.y, place.y, 0.0);
        read.near = vec2(x.x, y.x) / size;
        read.far = vec2(x.y, y.y) / size;
        read.far_share = vec2(x.z, y.z);
    }
    return read;
}

vec4 sampled_row(sampler2DArray texels, Read read, float y, int layer, float level) {
    vec4 near = textureLod(texels, vec3(read.near.x, y, layer), level);
    return CUBIC_X ? mix(near, textureLod(texels, vec3(read.far.x, y, layer), level), read.far_share.x) : near;
}

vec4 sampled_layer(sampler2DArray texels, Read read, int layer, float level) {
    vec4 near = sampled_row(texels, read, read.near.y, layer, level);
    return CUBIC_Y ? mix(near, sampled_row(texels, read, read.far.y, layer, level), read.far_share.y) : near;
}

// Interpolates by texel weights; texels beyond the edge are clamped to it.
vec4 weighed_layer(sampler2DArray texels, Read read, int layer, int level) {
    ivec2 last = textureSize(texels, level).xy - 1;
    const ivec2 BEGIN = ivec2(CUBIC_X ? 0 : 1, CUBIC_Y ? 0 : 1), END = ivec2(CUBIC_X ? 4 : 3, CUBIC_Y ? 4 : 3);
    vec4 sum = vec4(0.0);
    [[unroll]] for (int j = BEGIN.y; j < END.y; ++j) {
        int y = clamp(read.first.y + j, 0, last.y);
        vec4 row = vec4(0.0);
        [[unroll]] for (int i = BEGIN.x; i < END.x; ++i) {
            row += read.across[i] * texelFetch(texels, ivec3(clamp(read.first.x + i, 0, last.x), y, layer), level);
        }
        sum += read.up[j] * row;
    }
    return sum;
}

// Interpolates layer `layer` of mip level `level`, a whole number.
vec4 read_layer(sampler2DArray texels, Read read, int layer, float level) {
    if (WEIGHS_TEXELS) {
        return weighed_layer(texels, read, layer, int(level));
    }
    return sampled_layer(texels, read, layer, level);
}
