// Reads the layers between their texels.

// Place and weights of one read of all layers, made once per frequency.
struct Read {
    vec2 near;      // texture coordinates of the bilinear samples
    vec2 far;
    vec2 far_share; // weight of `far` along each axis; 0 for a bilinear kernel
};

Read read_at(vec2 frequency) {
    vec2 texel = frequency * optics.texels_per_frequency + optics.origin;
    Read read;
    if (optics.kernel == KERNEL_BILINEAR) {
        read.near = texel / optics.texture_size;
        read.far = read.near;
        read.far_share = vec2(0.0);
        return read;
    }
    // Cubic B-spline from four bilinear samples (Sigg & Hadwiger, GPU Gems 2, chapter 20): each sample stands between two
    // texels where the hardware's linear weights give the ratio of the spline's.
    vec2 whole = floor(texel - 0.5);
    vec2 t = texel - 0.5 - whole;
    vec2 t2 = t * t, t3 = t2 * t;
    vec2 w0 = (1.0 - 3.0 * t + 3.0 * t2 - t3) / 6.0;
    vec2 w1 = (4.0 - 6.0 * t2 + 3.0 * t3) / 6.0;
    vec2 w3 = t3 / 6.0;
    vec2 w2 = 1.0 - w0 - w1 - w3;
    read.near = (whole - 0.5 + w1 / (w0 + w1)) / optics.texture_size;
    read.far = (whole + 1.5 + w3 / (w2 + w3)) / optics.texture_size;
    read.far_share = w2 + w3;
    return read;
}

vec4 read_layer(Read read, int layer) {
    vec4 near_near = textureLod(layers, vec3(read.near, layer), 0.0);
    if (optics.kernel == KERNEL_BILINEAR) {
        return near_near;
    }
    vec4 far_near = textureLod(layers, vec3(read.far.x, read.near.y, layer), 0.0);
    vec4 near_far = textureLod(layers, vec3(read.near.x, read.far.y, layer), 0.0);
    vec4 far_far = textureLod(layers, vec3(read.far, layer), 0.0);
    return mix(mix(near_near, far_near, read.far_share.x), mix(near_far, far_far, read.far_share.x), read.far_share.y);
}
