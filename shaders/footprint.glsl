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
layout(constant_id = 23) const float FEWEST_SIDES = 1.0;
layout(constant_id = 24) const float ROUND = 0.0;
layout(constant_id = 25) const float NARROW = 0.0;
layout(constant_id = 26) const float MOST_SHARED = 1.0;

// Places in a footprint, whose weighted sum stands for the average over it: `Taps` of src/optics/footprint.rs.
struct Taps {
    float sides;  // taps on either side of the middle one, in the row along the longer axis
    vec2 along;   // the longer axis, as long as the standard deviation that is left to the row
    vec2 across;  // the same of the shorter axis
    float offset; // by how many steps the taps of a row are moved
    int rows;     // 1 or 3
};

// Taps in a line.
struct Row {
    float first;  // steps from the middle of the row to its first tap
    float last;   // just beyond the last one
    vec2 step;    // from one tap to the next
    float fall;   // the weight of a tap n steps from the middle is exp(-fall n^2)
    vec2 aside;   // from the middle of the footprint to that of the row
    float weight; // share of the row in the average
};

// For a footprint of which the variance `own` is left to the shorter axis, where a tap averages over the variance `read`, and all is blurred by
// the variance `blur` already. Taps stand `spacing` standard deviations of what one averages over apart.
Taps spaced_taps(Ellipse ellipse, float own, float read, float blur, float spacing) {
    float left = sqrt(max(ellipse.longer - read, 0.0));
    float tap = sqrt(read + blur);
    float rest = sqrt(max(own - read, 0.0));
    Taps taps;
    taps.sides = left > ROUND * tap ? min(ceil(TAP_REACH * left / (spacing * tap)), MOST_SIDES) : 0.0;
    taps.along = ellipse.axis * left;
    taps.across = vec2(-ellipse.axis.y, ellipse.axis.x) * rest;
    taps.offset = 0.0;
    taps.rows = rest > NARROW * tap ? 3 : 1;
    return taps;
}

// The taps of one of the samples that share them.
Taps shared_taps(Footprint footprint, Ellipse ellipse, float own, float read, float blur) {
    Taps taps = spaced_taps(ellipse, own, read, blur, TAP_SPACING * min(footprint.samples, MOST_SHARED));
    if (taps.sides > 0.0 && footprint.samples > 1.0) {
        taps.sides = max(taps.sides, FEWEST_SIDES);
        taps.offset = footprint.tap_offset;
    }
    return taps;
}

// Row number `row`: 0 along the longer axis, 1 and 2 beside it by the rule of Gauss and Hermite, with fewer taps.
Row row_of(Taps taps, int row) {
    const float ASIDE = 1.7320508, WEIGHT_ASIDE = 1.0 / 6.0, SPARSER_ASIDE = 1.5, OFFSET_ASIDE = 0.5, LN_4 = 1.3862944;
    float side = row == 0 ? 0.0 : row == 1 ? 1.0 : -1.0;
    float sides = row == 0 ? taps.sides : ceil(taps.sides / SPARSER_ASIDE);
    float offset = row == 0 ? taps.offset : sides > 1.0 ? fract(taps.offset + OFFSET_ASIDE + 0.5) - 0.5 : 0.0;
    // Three taps are those of Gauss and Hermite, too.
    float step = sides > 1.0 ? TAP_REACH / sides : ASIDE;
    Row own;
    own.first = sides > 0.0 ? offset - sides : 0.0;
    own.last = own.first + 2.0 * sides + 0.5;
    own.step = taps.along * step;
    own.fall = sides > 1.0 ? 0.5 * step * step : LN_4;
    own.aside = taps.across * (side * ASIDE);
    own.weight = row > 0 ? WEIGHT_ASIDE : taps.rows > 1 ? 1.0 - 2.0 * WEIGHT_ASIDE : 1.0;
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
