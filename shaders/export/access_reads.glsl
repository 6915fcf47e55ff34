// Reads from the textures of an export.

vec4 table_cubic(int column, int piece) {
    return functions_texel(ivec2(column, FIRST_CUBIC + piece));
}

vec4 table_row(float place, int row) {
    float column = clamp(place, 0.0, 1.0) * (COLUMNS - 1.0);
    float left = min(floor(column), COLUMNS - 2.0);
    vec4 a = functions_texel(ivec2(int(left), row));
    vec4 b = functions_texel(ivec2(int(left) + 1, row));
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
    vec2 a = mix(functions_texel(first).rg, functions_texel(first + ivec2(1, 0)).rg, place.x - corner.x);
    vec2 b = mix(functions_texel(first + ivec2(0, 1)).rg, functions_texel(first + ivec2(1, 1)).rg, place.x - corner.x);
    return mix(a, b, place.y - corner.y);
}

// R of the surface is in the table.
float dielectric(float index, float cosine) {
    return 1.0;
}
