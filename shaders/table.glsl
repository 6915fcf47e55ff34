// Reads a colour table: XYZ of q^2 |P|^2, summed over the spectrum, as Chebyshev polynomials in |w| over -(u, v).
// Its CPU twin is src/render/color_table.

layout(constant_id = 0) const int NODES = 4;    // coefficients of a polynomial: 1 ... 8
layout(constant_id = 1) const int MAX_TAPS = 1; // samples along a footprint; 0: the centre of the pixel alone

const int TEXELS = (3 * NODES + 3) / 4; // coefficient after coefficient, three channels each, four values a texel

layout(set = 0, binding = 15) uniform sampler2DArray color_table;

layout(set = 0, binding = 16, std140) uniform Table {
    float texture_per_uv;  // texture coordinate per unit of u
    float texels_per_uv;   // of the finest level
    float unit;            // what a stored 1 stands for
    float finest;          // level that the footprint of one finest texel reads: the filter's own width is taken off
} table;

const float LEAST_RANGE = 1e-3; // of w^2, where only texels of the edge stand

// The polynomials' values at |w|, where `toward` allows up to sqrt(4 - |toward|^2).
vec3 table_value(vec4 texels[TEXELS], vec2 toward, float w) {
    // T_n(x) by recurrence, x from -1 to 1 over the range.
    float x = min(2.0 * w * inversesqrt(max(4.0 - dot(toward, toward), LEAST_RANGE)) - 1.0, 1.0);
    float t[8];
    t[0] = 1.0;
    t[1] = x;
    for (int n = 2; n < 8; ++n) {
        t[n] = 2.0 * x * t[n - 1] - t[n - 2];
    }
    vec3 sum = vec3(0.0);
    for (int v = 0; v < 3 * NODES; ++v) {
        sum[v % 3] += texels[v / 4][v % 4] * t[v / 3];
    }
    return sum * table.unit;
}

// XYZ of f cos(theta_i) [1/sr] where `toward` = -(u, v), from mip level `level`.
vec3 table_xyz(Pair pair, vec2 toward, float level) {
    vec2 place = toward * table.texture_per_uv + 0.5;
    vec4 texels[TEXELS];
    for (int t = 0; t < TEXELS; ++t) {
        texels[t] = textureLod(color_table, vec3(place, t), level);
    }
    return table_value(texels, toward, pair.w) * pair.factor;
}

// The same averaged over a footprint with the edges `dx` and `dy`: `MAX_TAPS` samples at most along its longer side, each of
// a level as wide as the shorter side or as their distance.
vec3 table_xyz(Pair pair, vec2 toward, vec2 dx, vec2 dy) {
    float length_x = length(dx), length_y = length(dy);
    vec2 along = length_x > length_y ? dx : dy;
    float longer = max(max(length_x, length_y), 1e-9);
    float shorter = abs(dx.x * dy.y - dx.y * dy.x) / longer;
    // Finer than the finest texel there is nothing to resolve.
    float least = 1.0 / table.texels_per_uv;
    float taps = clamp(ceil(longer / max(shorter, least)), 1.0, float(MAX_TAPS));
    float level = max(log2(max(shorter, longer / taps) * table.texels_per_uv) + table.finest, 0.0);
    vec4 texels[TEXELS];
    for (int t = 0; t < TEXELS; ++t) {
        texels[t] = vec4(0.0);
    }
    vec2 step = along * (table.texture_per_uv / taps);
    vec2 place = toward * table.texture_per_uv + 0.5 - 0.5 * (taps - 1.0) * step;
    for (int tap = 0; tap < int(taps); ++tap) {
        for (int t = 0; t < TEXELS; ++t) {
            texels[t] += textureLod(color_table, vec3(place, t), level);
        }
        place += step;
    }
    return table_value(texels, toward, pair.w) * (pair.factor / taps);
}
