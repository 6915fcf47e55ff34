// Reads the layers between their texels.

// What a device compiles for. Software devices run both sides of a branch on anything else.
layout(constant_id = 0) const bool CUBIC_X = false;     // cubic B-spline along f_x, else linear
layout(constant_id = 1) const bool CUBIC_Y = false;     // the same along f_y
layout(constant_id = 2) const bool HALF_PLANE = true;   // the layers hold f_x >= 0 only
layout(constant_id = 3) const int Z_BANDS = 1;          // equal parts of z = k|w| with layers of their own
layout(constant_id = 4) const int PAIRS = 1;            // pairs of terms of each
layout(constant_id = 5) const bool FEWER_PAIRS = false; // small z need fewer
layout(constant_id = 6) const int SOURCE = 0;           // of the coefficients: see diffraction.glsl

// Place and weights of one read of all layers, made once per frequency.
struct Read {
    vec2 near;      // texture coordinates of the samples
    vec2 far;
    vec2 far_share; // weight of `far` along each axis where the kernel is cubic
};

// Weights of the four texels around a place at `t` in 0 ... 1 between the middle two (cubic B-spline).
vec4 spline_weights(float t) {
    float t2 = t * t, t3 = t2 * t;
    float w0 = (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0;
    float w1 = (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0;
    float w3 = t3 / 6.0;
    return vec4(w0, w1, 1.0 - w0 - w1 - w3, w3);
}

// Cubic B-spline along an axis from two linear samples (Sigg & Hadwiger, GPU Gems 2, chapter 20): each stands between two
// texels where the hardware's linear weights give the ratio of the spline's. x, y: the samples [texels]; z: weight of y.
vec3 spline_samples(float texel) {
    float whole = floor(texel - 0.5);
    vec4 w = spline_weights(texel - 0.5 - whole);
    return vec3(whole - 0.5 + w.y / (w.x + w.y), whole + 1.5 + w.w / (w.z + w.w), w.z + w.w);
}

Read read_at(vec2 frequency) {
    vec2 texel = frequency * optics.texels_per_frequency + optics.origin;
    vec3 x = vec3(texel.x, texel.x, 0.0), y = vec3(texel.y, texel.y, 0.0);
    if (CUBIC_X) {
        x = spline_samples(texel.x);
    }
    if (CUBIC_Y) {
        y = spline_samples(texel.y);
    }
    return Read(vec2(x.x, y.x) / optics.texture_size, vec2(x.y, y.y) / optics.texture_size, vec2(x.z, y.z));
}

vec4 read_row(Read read, float y, int layer) {
    vec4 near = textureLod(layers, vec3(read.near.x, y, layer), 0.0);
    if (!CUBIC_X) {
        return near;
    }
    return mix(near, textureLod(layers, vec3(read.far.x, y, layer), 0.0), read.far_share.x);
}

vec4 read_layer(Read read, int layer) {
    vec4 near = read_row(read, read.near.y, layer);
    if (!CUBIC_Y) {
        return near;
    }
    return mix(near, read_row(read, read.far.y, layer), read.far_share.y);
}
