// The two textures of an export and the reads from them.

#ifndef DIFFRACT_LAYOUT
#define DIFFRACT_LAYOUT(number)
#endif
// table.ktx2, a 2D array of RGBA16F with levels: linear between texels, nearest between levels, clamped to the edge.
DIFFRACT_LAYOUT(0) uniform sampler2DArray table;
// functions.ktx2, RGBA32F, read texel by texel: rows of the specular order and of the mean R, then a row of cubics for each piece, then
// the rows of the limit of energy.
DIFFRACT_LAYOUT(1) uniform sampler2D functions;

// Numbers of the table.
struct Table {
    float texture_per_uv; // texture coordinate per unit of u
    float coherence;      // variance of u that coherence averages over
    float unit;           // what a stored 1 stands for [1/sr]
    float finest;         // variance of u that the finest level averages over
    float per_growth;     // 1 over the variance by which level 1 is wider than the finest
    float pieces;         // of the range of |w|
    float last_level;
};

const float COLUMNS = 128.0; // of the rows of the specular order
const float SIDE = 65.0;       // of the square of directions of the limit of energy
