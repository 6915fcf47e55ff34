// Wavelengths of colours of n x m copies of the patch: at the orders and between them. The f64 twin, with the
// derivation, is src/optics/orders.rs. SHORTEST and LONGEST are defined in brdf.glsl. `nodes` holds the colour
// functions as densities over wavenumber, 1/LONGEST to 1/SHORTEST.

struct Copies {
    vec2 count;       // n, m
    vec2 period;      // T_x, T_y [um]
    float colour_lag; // lag beyond which the colour functions are negligible [um]
    float tolerance;  // of the sum over wavelengths
};

const float LEAST_LAG = 1e-3; // [um]

// Wavelengths of a pair of directions: `index` of `per_period` in each period of the sharper axis.
struct Sampling {
    float periods;  // of the sharper axis per wavenumber [um]
    float crossed;  // of the other axis
    float n;        // copies along the sharper axis
    float m;        // along the other
    bool every;     // all parts with the exact factor; else order and odd parts, or order alone
    int parts;      // of a period
    int per_period; // wavelengths of a period
    float order;    // weight of the order [periods]
};

Sampling sampling(Copies copies, vec2 uv) {
    Sampling s;
    vec2 lag = copies.count * abs(uv) * copies.period;
    bool y = lag.y > lag.x;
    s.n = y ? copies.count.y : copies.count.x;
    s.m = y ? copies.count.x : copies.count.y;
    float other = min(lag.x, lag.y);
    s.crossed = other / s.m;
    s.periods = max(max(lag.x, lag.y), LEAST_LAG) / s.n;
    float others = (other + copies.colour_lag) / s.periods;
    bool orders = others <= copies.tolerance * s.n;
    s.every = !orders && others + 1.0 > s.n;
    s.parts = orders ? 0 : s.every ? int(min(ceil(others + s.n), 2e9)) : 2 * int(ceil(others + 1.0));
    s.per_period = s.every ? s.parts : 1 + s.parts / 2;
    s.order = s.every ? 1.0 / float(s.parts) : 1.0 / s.n - float(s.parts) / (4.0 * s.n * s.n);
    return s;
}

// Returns the number of the first wavelength at `place` periods or beyond.
int first_from(Sampling s, float place) {
    float whole = floor(place), rest = (place - whole) * float(s.parts);
    float within = s.every ? ceil(rest) : s.parts == 0 ? ceil(place - whole) : rest == 0.0 ? 0.0 : ceil(0.5 * (rest + 1.0));
    return int(whole) * s.per_period + int(within);
}

// Returns sin(pi x) for |x| <= 1/2, to relative rounding. The sine of devices may be inexact for small arguments, and
// orders are quotients of two small ones.
float sin_pi(float x) {
    float t = x * x;
    return x * (3.14159265 + t * (-5.16771278 + t * (2.55016404 + t * (-0.599264529 + t * (0.0821458866 + t * -0.00737043095)))));
}

// Returns |S|^2/count^2 at a phase in periods: 1 at the orders.
float periodic_factor(float count, float phase) {
    float away = phase - round(phase); // exact
    float turns = count * away;
    float ratio = sin_pi(turns - round(turns)) / (count * sin_pi(away));
    return abs(turns) < 1e-4 ? 1.0 : ratio * ratio;
}

// Returns the range of the visible wavelengths: the first number and the one after the last.
ivec2 seen_orders(Sampling s) {
    return ivec2(first_from(s, s.periods / LONGEST), first_from(s, s.periods / SHORTEST));
}

// Returns the wavenumber of a wavelength [1/um], and the weight of the response of one patch there [periods], with both
// factors.
vec2 order_at(Sampling s, int number) {
    int period = number / s.per_period, index = number - period * s.per_period;
    float share = index == 0 ? 0.0 : float(s.every ? index : 2 * index - 1) / float(s.parts);
    float wavenumber = (float(period) + share) / s.periods;
    // Between the orders the factor of the sharper axis is exact, or at odd parts replaced by its envelope.
    float envelope = s.n * sin_pi(min(share, 1.0 - share));
    float between = (s.every ? periodic_factor(s.n, share) : 1.0 / (envelope * envelope)) / float(s.parts);
    return vec2(wavenumber, (index == 0 ? s.order : between) * periodic_factor(s.m, wavenumber * s.crossed));
}

// Returns XYZ per unit of wavenumber [um].
vec3 colour_density(float wavenumber) {
    float columns = float(textureSize(nodes, 0).x);
    float column = (wavenumber - 1.0 / LONGEST) / (1.0 / SHORTEST - 1.0 / LONGEST) * (columns - 1.0) + 0.5;
    return textureLod(nodes, vec2(column / columns, 0.5), 0.0).rgb;
}
