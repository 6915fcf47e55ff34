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
layout(constant_id = 25) const float MOST_SHARED = 1.0;

// Places in a footprint, whose sum stands for the average over it: `Taps` of src/optics/footprint.rs.
struct Taps {
    float first; // steps from the middle of the footprint to the first tap of a row
    float last;  // just beyond the last one
    vec2 step;   // from one tap to the next
    float fall;  // the weight of a tap n steps from the middle is exp(-fall n^2)
    vec2 aside;  // from the middle of the footprint to the row; a second one is opposite
    int rows;
};

// For a footprint of which the variance `own` is left to the shorter axis, where a tap averages over the variance `read`, and all is blurred by
// the variance `blur` already.
Taps taps_of(Footprint footprint, Ellipse ellipse, float own, float read, float blur) {
    float left = sqrt(max(ellipse.longer - read, 0.0));
    float tap = sqrt(read + blur);
    bool is_long = left > ROUND * tap;
    float needed = is_long ? ceil(TAP_REACH * left / (TAP_SPACING * tap)) : 0.0;
    float sides = clamp(ceil(needed / min(footprint.samples, MOST_SHARED)), min(needed, FEWEST_SIDES), MOST_SIDES);
    float step = TAP_REACH / max(sides, 1.0);
    Taps taps;
    taps.first = is_long ? footprint.tap_offset - sides : 0.0;
    taps.last = taps.first + 2.0 * sides + 0.5;
    taps.step = ellipse.axis * (step * left);
    taps.fall = 0.5 * step * step;
    float rest = sqrt(max(own - read, 0.0));
    bool wide = rest > ROUND * tap;
    taps.rows = wide ? 2 : 1;
    taps.aside = wide ? vec2(-ellipse.axis.y, ellipse.axis.x) * rest : vec2(0.0);
    return taps;
}

// The least variance that a tap has to average over, so that MOST_SIDES suffice.
float least_own(Ellipse ellipse, float blur) {
    const float PART = TAP_REACH / (TAP_SPACING * MOST_SIDES);
    return max(ellipse.longer * (PART * PART) - blur, 0.0);
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
