// Textures of an export as plain images, which are read texel by texel: no levels, no arrays, any sampler.

// table2d.exr: of each level, all layers side by side, FLAT_COLUMNS in a row of the finest level and twice as many with each level; then the rows of the next level.
DIFFRACT_LAYOUT(0) uniform sampler2D table;
// functions.exr: rows of the specular order and of the mean R, then a row of cubics for each piece, then the rows of the limit of energy.
DIFFRACT_LAYOUT(1) uniform sampler2D functions;

vec4 functions_texel(ivec2 place) {
    return texelFetch(functions, ivec2(place.x, LAST_ROW_FIRST ? FUNCTIONS_HEIGHT - 1 - place.y : place.y), 0);
}

vec4 flat_texel(ivec2 place) {
    return texelFetch(table, ivec2(place.x, LAST_ROW_FIRST ? FLAT_HEIGHT - 1 - place.y : place.y), 0);
}

vec4 table_texel(vec3 place, float mip) {
    int level = int(mip);
    int first_row = 0;
    for (int finer = 0; finer < level; ++finer) {
        int columns = FLAT_COLUMNS << finer;
        first_row += (FLAT_SIDE >> finer) * ((FLAT_LAYERS + columns - 1) / columns);
    }
    int layer = int(place.z + 0.5);
    int columns = FLAT_COLUMNS << level;
    int side = FLAT_SIDE >> level;
    int row = layer / columns;
    ivec2 corner = ivec2((layer - row * columns) * side, first_row + row * side);
    // Beyond the outermost texels the numbers fall to 0 within one texel.
    float width = float(side);
    vec2 inside = clamp(0.5 * width + 0.5 - abs(place.xy - 0.5) * width, 0.0, 1.0);
    vec2 at = clamp(place.xy * width - 0.5, 0.0, width - 1.0);
    vec2 low = min(floor(at), width - 2.0);
    vec2 share = at - low;
    ivec2 first = corner + ivec2(low);
    vec4 upper = mix(flat_texel(first), flat_texel(first + ivec2(1, 0)), share.x);
    vec4 lower = mix(flat_texel(first + ivec2(0, 1)), flat_texel(first + ivec2(1, 1)), share.x);
    return inside.x * inside.y * mix(upper, lower, share.y);
}
