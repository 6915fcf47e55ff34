// Reads from the textures of an export.

vec4 table_texel(vec3 place, float mip) {
    float side = float(textureSize(table, int(mip)).x);
    // Beyond the outermost texels the numbers fall to 0 within one texel.
    vec2 inside = clamp(0.5 * side + 0.5 - abs(place.xy - 0.5) * side, 0.0, 1.0);
    return inside.x * inside.y * textureLod(table, place, mip);
}

vec4 table_cubic(int column, int piece) {
    return texelFetch(functions, ivec2(column, FIRST_CUBIC + piece), 0);
}

vec4 table_row(float place, int row) {
    float column = clamp(place, 0.0, 1.0) * (COLUMNS - 1.0);
    float left = min(floor(column), COLUMNS - 2.0);
    vec4 a = texelFetch(functions, ivec2(int(left), row), 0);
    vec4 b = texelFetch(functions, ivec2(int(left) + 1, row), 0);
    return mix(a, b, column - left);
}

// Returns the limit of energy of a direction: the directional albedo over the reflectance of a flat
// surface, and the root of the factor of a pigment.
vec2 energy_at(vec3 direction) {
    float z = max(direction.z, 0.0);
    vec2 place = (0.5 + 0.5 * direction.xy * inversesqrt((1.0 + sqrt(z)) * (1.0 + z))) * (SIDE - 1.0);
    place = clamp(place, vec2(0.0), vec2(SIDE - 1.0));
    vec2 corner = min(floor(place), vec2(SIDE - 2.0));
    ivec2 first = ivec2(corner) + ivec2(0, FIRST_ENERGY);
    vec2 a = mix(texelFetch(functions, first, 0).rg, texelFetch(functions, first + ivec2(1, 0), 0).rg, place.x - corner.x);
    vec2 b = mix(texelFetch(functions, first + ivec2(0, 1), 0).rg, texelFetch(functions, first + ivec2(1, 1), 0).rg, place.x - corner.x);
    return mix(a, b, place.y - corner.y);
}

// R of the surface is in the table.
float dielectric(float index, float cosine) {
    return 1.0;
}
