// Numbers of an export.

#ifndef DIFFRACT_LAYOUT
#define DIFFRACT_LAYOUT(number)
#endif

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
const float SIDE = 65.0;     // of the square of directions of the limit of energy
