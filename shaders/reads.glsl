// Sums bilinear samples of an array texture, walking outward and through the layers as shading does. Neighbouring
// pixels read neighbouring texels, or each pixel begins at a random place.

// Hashes a pixel to a random place by multiplication (Knuth); neighbours are spread over the whole range.
vec2 elsewhere(uvec2 pixel) {
    uint h = (pixel.x * 2654435761u) ^ (pixel.y * 2246822519u);
    h = (h ^ (h >> 15)) * 3266489917u;
    return vec2(h & 0xffffu, h >> 16) / 65536.0;
}

vec4 reads_of(sampler2DArray texels, vec2 pixel, bool scattered, int samples) {
    ivec3 size = textureSize(texels, 0);
    vec2 place = scattered ? elsewhere(uvec2(pixel)) : 0.5 + pixel * 0.25 / vec2(size.xy);
    vec2 walk = vec2(1.5) / vec2(size.xy);
    vec4 sum = vec4(0.0);
    int layer = 0;
    for (int i = 0; i < samples; ++i) {
        sum += textureLod(texels, vec3(fract(place), layer), 0.0);
        layer += 1;
        if (layer == size.z) {
            layer = 0;
            place += walk;
        }
    }
    return sum;
}
