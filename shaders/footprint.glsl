// Ellipse of (u, v) that a pixel averages over, by its axes.

struct Ellipse {
    vec2 axis;   // unit vector along the longer axis
    float longer; // variance along it
    float shorter;
};

// Returns the covariance of (u, v) under a footprint: uu, uv, vv.
vec3 covariance(Footprint footprint) {
    vec2 dx = footprint.dx, dy = footprint.dy;
    return vec3(dx.x * dx.x + dy.x * dy.x, dx.x * dx.y + dy.x * dy.y, dx.y * dx.y + dy.y * dy.y);
}

Ellipse ellipse_of(vec3 c) {
    float mean = 0.5 * (c.x + c.z), difference = 0.5 * (c.x - c.z);
    float spread = sqrt(difference * difference + c.y * c.y);
    // Both forms are parallel to the longer axis; at most one of them is small.
    vec2 axis = difference > 0.0 ? vec2(spread + difference, c.y) : vec2(c.y, spread - difference);
    // A circle has no longer axis.
    axis *= inversesqrt(max(dot(axis, axis), 1e-30));
    return Ellipse(axis, mean + spread, max(mean - spread, 0.0));
}

// The constants of src/filter/taps.rs.
const float SPACING = 2.2;
const float REACH = 2.8;
const float LONG_REACH = 4.0;
const float OVERHANG = 10.0;
const float KEPT = 0.9775;
const float MOST_OF_ROW = 201.0;
const float ROUND = 0.2;

// Variances of the level read and of the next coarser one, without coherence: `Levels` of src/filter/taps.rs.
struct Levels {
    float read;
    float next; // no more than `read` for the coarsest level
    float blur; // of coherence
};

// Points on a line with Gaussian weights, symmetric about the middle: `Line` of src/filter/taps.rs.
struct Line {
    float count;
    float step; // distance between points
    float fall; // the weight n steps from the middle is exp(-fall n^2) / norm
    float norm;
};

// Rows of taps whose weighted sum is the average over a footprint: `Taps` of src/filter/taps.rs.
struct Taps {
    Levels levels;
    vec2 axis;    // unit vector along the longer axis
    float longer; // variance along it
    float share;  // weight of the row of the next coarser level
    float aside;  // distance from the middle of two rows of the coarsest level
    int rows;     // 1 or 2
};

// Row of taps along the longer axis: `Row` of src/filter/taps.rs.
struct Row {
    float first;   // steps from the middle to the first tap
    vec2 step;     // from one tap to the next
    float fall;    // the weight of the tap n steps from the middle is weight exp(-fall n^2)
    vec2 aside;    // from the middle of the footprint to that of the row
    float weight;
    float coarser; // 1 if the row reads the next coarser level
};

// Spreads points over the standard deviation `deviation`, each of which averages over the standard deviation `tap`. The
// weighted variance of the points is that of the line.
Line line_of(float deviation, float tap) {
    if (deviation <= ROUND * tap) {
        return Line(1.0, 0.0, 0.0, 1.0);
    }
    float reach = clamp(LONG_REACH - OVERHANG * tap / deviation, REACH, LONG_REACH);
    float count = clamp(ceil(2.0 * reach * deviation / (KEPT * SPACING * tap) + 1.0), 2.0, MOST_OF_ROW);
    float h = 2.0 * reach / count;
    float fall = 0.5 * h * h, norm = 0.0, moment = 0.0;
    for (float n = -0.5 * (count - 1.0); n < 0.5 * count; n += 1.0) {
        float weight = exp(-fall * n * n);
        norm += weight;
        moment += weight * n * n;
    }
    return Line(count, deviation * sqrt(norm / moment), fall, norm);
}

// Returns the share of the coarser level for which both are together as high in the middle as a Gaussian of the variance
// `across`: `share_between` of src/filter/taps.rs.
float share_between(Levels levels, float across) {
    float finer = inversesqrt(levels.read + levels.blur), coarser = inversesqrt(levels.next + levels.blur);
    float asked = inversesqrt(max(across, levels.read) + levels.blur);
    return clamp((finer - asked) / (finer - coarser), 0.0, 1.0);
}

// Returns the taps of a footprint whose variance along the shorter axis is `across`.
Taps taps_of(Ellipse ellipse, float across, Levels levels) {
    float rest = max(across - levels.read, 0.0);
    float share = levels.next > levels.read ? share_between(levels, across) : 0.0;
    bool beyond = levels.next <= levels.read && rest > ROUND * ROUND * (levels.read + levels.blur);
    return Taps(levels, ellipse.axis, ellipse.longer, share, beyond ? sqrt(rest) : 0.0, share > 0.0 || beyond ? 2 : 1);
}

// Returns row number `number`. With two levels, both rows together have the variance of the longer axis.
Row row_of(Taps taps, int number) {
    bool coarser = taps.share > 0.0 && number == 1;
    float read = coarser ? taps.levels.next : taps.levels.read;
    float whole = (taps.longer - taps.share * max(taps.longer, taps.levels.next)) / max(1.0 - taps.share, 1e-3);
    float left = (coarser ? taps.longer : whole) - read;
    Line line = line_of(sqrt(max(left, 0.0)), sqrt(read + taps.levels.blur));
    float weight = coarser ? taps.share : taps.aside > 0.0 ? 0.5 : 1.0 - taps.share;
    Row row;
    row.first = -0.5 * (line.count - 1.0);
    row.step = taps.axis * line.step;
    row.fall = line.fall;
    row.aside = vec2(-taps.axis.y, taps.axis.x) * (number == 0 ? -taps.aside : taps.aside);
    row.weight = weight / line.norm;
    row.coarser = coarser ? 1.0 : 0.0;
    return row;
}

// Returns the smallest variance of a tap for which MOST_OF_ROW taps suffice.
float least_own(Ellipse ellipse, float blur) {
    float part = 2.0 * LONG_REACH / (KEPT * SPACING * MOST_OF_ROW);
    return max(ellipse.longer * (part * part) - blur, 0.0);
}

// Returns the level whose variance is at most `ratio` times that of the finest; each level has twice the variance of the
// previous one. The bound handles log2(1) rounded below 0.
float level_of_ratio(float ratio) {
    return max(floor(log2(ratio)), 0.0);
}

// Returns the normal distribution of covariance `c` at `d`.
float normal_density(vec3 c, vec2 d) {
    float det = c.x * c.z - c.y * c.y;
    float r2 = (c.z * d.x * d.x - 2.0 * c.y * d.x * d.y + c.x * d.y * d.y) / det;
    return exp(-0.5 * r2) * inversesqrt(det) / (2.0 * PI);
}
