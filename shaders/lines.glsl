// Colours from spectra on the lines of a grid: the nodes of the integral over the spectrum stand where the ray -(u, v)/lambda
// crosses a line, so that a node is read from neighbours along that line. Its twin is src/precompute/lines.rs.

layout(constant_id = 9) const bool LINES = false;       // whether there are any
layout(constant_id = 10) const int GROUPED = 1;          // pairs of terms beside each other
layout(constant_id = 11) const bool CUBIC_LINES = false; // cubic B-spline along a line, else linear

// A pair of terms at `t` in 0 ... 1 between the texel `at` and its neighbour along the line.
vec4 read_line(ivec3 at, float t) {
    ivec3 next = ivec3(GROUPED, 0, 0);
    if (!CUBIC_LINES) {
        return mix(texelFetch(lines, at, 0), texelFetch(lines, at + next, 0), t);
    }
    vec4 w = spline_weights(t);
    return w.x * texelFetch(lines, at - next, 0) + w.y * texelFetch(lines, at, 0)
           + w.z * texelFetch(lines, at + next, 0) + w.w * texelFetch(lines, at + 2 * next, 0);
}

bool crosses_lines(Pair pair) {
    return max(abs(pair.toward.x), abs(pair.toward.y)) >= lines_at.from;
}

// XYZ of q^2 |P|^2, summed over the lines that a ray crosses up to the wavenumber `largest`; nothing where that is 0.
vec3 sum_over_lines(Pair pair, float largest) {
    bool second = abs(pair.toward.y) > abs(pair.toward.x);
    vec2 ray = second ? pair.toward.yx : pair.toward; // across the lines, along them
    float conjugate = pair.conjugate;
    if (HALF_PLANE && ray.x < 0.0) {
        ray = -ray;
        conjugate = -conjugate;
    }
    float per_wavenumber = abs(ray.x) * (second ? lines_at.across.y : lines_at.across.x); // lines
    float step = 1.0 / max(per_wavenumber, 1e-6);
    int row = clamp(int((log2(step) - lines_at.first_row) * lines_at.rows_per_octave + 0.5), 0,
                    textureSize(line_weights, 0).y - 1);
    // The wavenumbers that the eye sees enough of. They stand in the texture because lavapipe (Mesa 22.3) crashes where the
    // end of a loop follows from a uniform in this way.
    vec2 range = vec2(texelFetch(line_weights, ivec2(0, row), 0).w, texelFetch(line_weights, ivec2(1, row), 0).w);
    int first = int(ceil(range.x * per_wavenumber - 1.0));
    int last = largest > 0.0 ? int(floor(min(range.y * per_wavenumber + 1.0, largest * per_wavenumber))) : -1;
    float points_per_line = ray.y * step * (second ? lines_at.along.y : lines_at.along.x);
    int side = ray.x < 0.0 ? -1 : 1;
    int behind = second ? (PAIRS + GROUPED - 1) / GROUPED * Z_BANDS : 0;
    float bands_per_line = 2.0 * PI * pair.w * optics.bands_per_z * step;
    float column_per_line = step * lines_at.columns_per_wavenumber;
    float first_column = -lines_at.first_column * lines_at.columns_per_wavenumber;
    vec3 xyz = vec3(0.0);
    for (int line = first; line <= last; ++line) {
        float number = float(line);
        float point = number * points_per_line + lines_at.origin.x;
        float whole = floor(point);
        ivec2 at = ivec2(int(whole) * GROUPED, int(lines_at.origin.y) + side * line);
        float place = number * bands_per_line;
        int band = min(int(place), Z_BANDS - 1);
        float column = min(place - float(band), 1.0) * optics.last_column;
        vec2 p = vec2(0.0);
        int count = FEWER_PAIRS ? pairs_at(place / optics.bands_per_z) : PAIRS;
        int k = 0;
        do {
            vec4 c = coefficients_at(column, k * Z_BANDS + band);
            c.yw *= conjugate;
            vec4 s = read_line(ivec3(at.x + k % GROUPED, at.y, behind + k / GROUPED * Z_BANDS + band), point - whole);
            p += sum_of_terms(c, s);
            ++k;
        } while (k < count);
        float weight = clamp(number * column_per_line + first_column, 0.0, lines_at.last_column);
        xyz += texelFetch(line_weights, ivec2(int(weight), row), 0).xyz * dot(p, p);
    }
    return xyz * (step * lines_at.unit);
}
