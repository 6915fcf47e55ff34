// The two textures of an export and the reads from them.

#ifndef DIFFRACT_LAYOUT
#define DIFFRACT_LAYOUT(number)
#endif
// table.ktx2, a 2D array of RGBA16F with levels: linear between texels, nearest between levels, clamped to the edge.
DIFFRACT_LAYOUT(0) uniform sampler2DArray table;
// functions.ktx2, RGBA32F, read texel by texel: rows of the specular order and of the mean R, then a row of cubics for each piece.
DIFFRACT_LAYOUT(1) uniform sampler2D functions;

const float COLUMNS = 128.0; // of the rows of the specular order
const int FIRST_CUBIC = 18;  // row of the cubics of the first piece

vec4 table_texel(vec3 place, float level) {
    float side = float(textureSize(table, int(level)).x);
    // Beyond the outermost texels the numbers fall to 0 within one texel.
    vec2 inside = clamp(0.5 * side + 0.5 - abs(place.xy - 0.5) * side, 0.0, 1.0);
    return inside.x * inside.y * textureLod(table, place, level);
}

vec4 table_cubic(int column, int piece) {
    return texelFetch(functions, ivec2(column, FIRST_CUBIC + piece), 0);
}

vec3 table_row(float place, int row) {
    float column = clamp(place, 0.0, 1.0) * (COLUMNS - 1.0);
    float left = min(floor(column), COLUMNS - 2.0);
    vec3 a = texelFetch(functions, ivec2(int(left), row), 0).rgb;
    vec3 b = texelFetch(functions, ivec2(int(left) + 1, row), 0).rgb;
    return mix(a, b, column - left);
}

// R of the surface is in the table.
float dielectric(float index, float cosine) {
    return 1.0;
}
