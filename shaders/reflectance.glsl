// Reflectance that depends on the wavelength: R over the cosine at the half vector and the wavenumber. Other
// reflectances are in the factor of a pair. The Rust side is src/render/source/reflectance.rs.

const float SHORTEST = 0.380; // of the visible range [um]
const float LONGEST = 0.780;

layout(set = 1, binding = REFLECTANCE_BINDING) uniform sampler2D reflectances; // wavenumbers of the visible range, in rows

float reflectance_at(Pair pair, float wavenumber) {
    const float FIRST = 1.0 / LONGEST, LAST = 1.0 / SHORTEST;
    if (REFLECTANCE_LAW != SPECTRAL) {
        return 1.0;
    }
    vec2 size = vec2(textureSize(reflectances, 0));
    vec2 place = vec2(pair.cos_half, (wavenumber - FIRST) / (LAST - FIRST));
    return textureLod(reflectances, (place * (size - 1.0) + 0.5) / size, 0.0).r;
}
