// The ellipse of (u, v) that a pixel averages over, along its axes.

struct Ellipse {
    vec2 axis;   // unit vector along the longer axis
    float longer; // variance along it
    float shorter;
};

// Covariance of (u, v) under a footprint whose edges are `dx` and `dy`: uu, uv, vv.
vec3 covariance(Footprint footprint) {
    vec2 dx = footprint.dx, dy = footprint.dy;
    return vec3(dx.x * dx.x + dy.x * dy.x, dx.x * dx.y + dy.x * dy.y, dx.y * dx.y + dy.y * dy.y);
}

Ellipse ellipse_of(vec3 c) {
    float mean = 0.5 * (c.x + c.z), difference = 0.5 * (c.x - c.z);
    float spread = sqrt(difference * difference + c.y * c.y);
    // Both forms are along the longer axis; each is small where the other is not.
    vec2 axis = difference > 0.0 ? vec2(spread + difference, c.y) : vec2(c.y, spread - difference);
    // A circle has no longer axis.
    axis *= inversesqrt(max(dot(axis, axis), 1e-30));
    return Ellipse(axis, mean + spread, max(mean - spread, 0.0));
}

// The constants of src/optics/footprint.rs.
layout(constant_id = 20) const float TAP_SPACING = 2.0;
layout(constant_id = 21) const float TAP_REACH = 2.0;
layout(constant_id = 22) const float MOST_SIDES = 1.0;
layout(constant_id = 23) const float ROUND = 0.0;
layout(constant_id = 24) const float NARROW = 0.0;

// What a tap averages over: `Levels` of src/optics/footprint.rs.
struct Levels {
    float read;
    float next; // of the next coarser level; no more than `read` where there is none
    float blur;
};

// Places in a footprint, whose weighted sum stands for the average over it: `Taps` of src/optics/footprint.rs.
struct Taps {
    Levels levels;
    vec2 axis;     // unit vector along the longer axis
    float longer;  // variance along it
    float rest;    // variance across it that is left
    float coarser; // weight of the row of the next coarser level, the first of three; or 0
    float aside;   // distance of the other rows from the middle
    int rows;      // 1 to 4
};

// Taps in a line.
struct Row {
    float first;  // steps from the middle of the row to its first tap
    float last;   // just beyond the last one
    vec2 step;    // from one tap to the next
    float fall;   // the weight of a tap n steps from the middle is exp(-fall n^2)
    vec2 aside;   // from the middle of the footprint to that of the row
    float weight; // share of the row in the average
    float coarser; // 1 where it reads the next coarser level
};

const float ASIDE = 1.7320508, WEIGHT_ASIDE = 1.0 / 6.0, OFFSET_ASIDE = 0.5, LN_4 = 1.3862944;

layout(constant_id = 25) const float MIDDLE_ROW = 0.0;
layout(constant_id = 26) const float BEND_OF_ROWS = 0.6;

// The weight of the coarser of two levels, and the variance that is left to where the finer one is read over the difference of their variances:
// `between_levels` of src/optics/footprint.rs.
vec2 between_levels(float s, float bend) {
    return vec2(s * s * (1.0 + bend - bend * s), s * (1.0 - bend * s) / (1.0 + s - bend * s * s));
}

// Where both levels are read in the middle alone: `mixed_weight` of src/optics/footprint.rs.
layout(constant_id = 27) const float MIXED_BEND = 0.0;
layout(constant_id = 28) const float MIXED_TURN = 0.0;
layout(constant_id = 29) const bool MIXED = false; // whether they are

float mixed_weight(float s, vec2 bends) {
    return s * (1.0 + (bends.x - bends.y * s) * (1.0 - s));
}

// For a footprint of which the variance `own` is left to the shorter axis.
Taps taps_of(Ellipse ellipse, float own, Levels levels) {
    Taps taps = Taps(levels, ellipse.axis, ellipse.longer, max(own - levels.read, 0.0), 0.0, 0.0, 1);
    if (taps.rest > NARROW * NARROW * (levels.read + levels.blur)) {
        taps.rows = 3;
        taps.aside = ASIDE * sqrt(taps.rest);
        if (levels.next > levels.read) {
            float between = levels.next - levels.read;
            if (MIXED) {
                taps.coarser = mixed_weight(min(taps.rest / between, 1.0), vec2(MIXED_BEND, MIXED_TURN));
                taps.aside = 0.0;
                taps.rows = 2;
                return taps;
            }
            vec2 parts = between_levels(min(taps.rest / between, 1.0), BEND_OF_ROWS);
            taps.coarser = parts.x;
            taps.aside = sqrt(parts.y * between / (1.0 - MIDDLE_ROW));
            taps.rows = MIDDLE_ROW > 0.0 ? 4 : 3;
        }
    }
    return taps;
}

// Row number `row`.
Row row_of(Taps taps, int row) {
    bool mixed = taps.coarser > 0.0;
    bool coarser = mixed && row == 0;
    float read = coarser ? taps.levels.next : taps.levels.read;
    float left = taps.longer - read;
    float weight = taps.rows == 1 ? 1.0 : row == 0 ? 1.0 - 2.0 * WEIGHT_ASIDE : WEIGHT_ASIDE;
    if (mixed) {
        float share = taps.rows == 2 ? 1.0 : row == 3 ? MIDDLE_ROW : 0.5 * (1.0 - MIDDLE_ROW);
        weight = row == 0 ? taps.coarser : share * (1.0 - taps.coarser);
        // All rows together have the variance of the longer axis.
        float whole = (taps.longer - taps.coarser * max(taps.longer, taps.levels.next)) / max(1.0 - taps.coarser, 1e-3);
        left = row == 0 ? left : whole - read;
    }
    left = sqrt(max(left, 0.0));
    float tap = sqrt(read + taps.levels.blur);
    float sides = left > ROUND * tap ? min(ceil(TAP_REACH * left / (TAP_SPACING * tap)), MOST_SIDES) : 0.0;
    // Rows beside each other stand half a step apart.
    bool even = row == 0 || row == 3 || (mixed && taps.rows <= 3 && row == 1);
    float moved = sides > 1.0 && !even ? OFFSET_ASIDE : 0.0;
    // Three taps are those of Gauss and Hermite, too.
    float step = sides > 1.0 ? TAP_REACH / sides : ASIDE;
    float side = row == 1 ? 1.0 : row == 2 ? -1.0 : 0.0;
    Row own;
    own.first = -sides - moved;
    own.last = own.first + 2.0 * sides + 0.5;
    own.step = taps.axis * (left * step);
    own.fall = sides > 1.0 ? 0.5 * step * step : LN_4;
    own.aside = vec2(-taps.axis.y, taps.axis.x) * (side * taps.aside);
    own.weight = weight;
    own.coarser = coarser ? 1.0 : 0.0;
    return own;
}

// The least variance that a tap has to average over, so that MOST_SIDES suffice.
float least_own(Ellipse ellipse, float blur) {
    float part = TAP_REACH / (TAP_SPACING * MOST_SIDES);
    return max(ellipse.longer * (part * part) - blur, 0.0);
}

// The level whose variance is at most `ratio` times that of the finest, where each level has four times the one before. log2(1) may be rounded
// to less than 0.
float level_of_ratio(float ratio) {
    return max(floor(0.5 * log2(ratio)), 0.0);
}

// The normal distribution of covariance `c` at `d`.
float normal_density(vec3 c, vec2 d) {
    float det = c.x * c.z - c.y * c.y;
    float r2 = (c.z * d.x * d.x - 2.0 * c.y * d.x * d.y + c.x * d.y * d.y) / det;
    return exp(-0.5 * r2) * inversesqrt(det) / (2.0 * PI);
}
