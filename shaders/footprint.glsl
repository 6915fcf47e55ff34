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

// The level, with a fraction, whose variance is `ratio` times that of the finest, where each level has four times the one before. A linear
// mixture of two levels has the mean of their variances.
float level_of_ratio(float ratio) {
    float r = max(ratio, 1.0);
    float lower = floor(0.5 * log2(r));
    return lower + clamp((r * exp2(-2.0 * lower) - 1.0) / 3.0, 0.0, 1.0);
}

// The normal distribution of covariance `c` at `d`.
float normal_density(vec3 c, vec2 d) {
    float det = c.x * c.z - c.y * c.y;
    float r2 = (c.z * d.x * d.x - 2.0 * c.y * d.x * d.y + c.x * d.y * d.y) / det;
    return exp(-0.5 * r2) * inversesqrt(det) / (2.0 * PI);
}
