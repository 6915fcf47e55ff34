// Textures of an export as a 2D array with levels.

// table.ktx2, a 2D array of RGBA16F with levels: linear between texels, nearest between levels, clamped to the edge.
DIFFRACT_LAYOUT(0) uniform sampler2DArray table;
// functions.ktx2, RGBA32F, read texel by texel: rows of the specular order and of the mean R, then a row of cubics for each piece, then
// the rows of the limit of energy.
DIFFRACT_LAYOUT(1) uniform sampler2D functions;

vec4 functions_texel(ivec2 place) {
    return texelFetch(functions, place, 0);
}

vec4 table_texel(vec3 place, float mip) {
    float side = float(textureSize(table, int(mip)).x);
    // Beyond the outermost texels the numbers fall to 0 within one texel.
    vec2 inside = clamp(0.5 * side + 0.5 - abs(place.xy - 0.5) * side, 0.0, 1.0);
    return inside.x * inside.y * textureLod(table, place, mip);
}
