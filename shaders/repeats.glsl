// Colours through n x m copies of the patch: the response of one, which the layers hold, times the periodic factors.
#include "orders.glsl"

layout(push_constant) uniform Repeats {
    Copies copies;
    uint asked; // queries that are answered at once; none in a picture
};

// XYZ of f cos(theta_i) [1/sr].
vec3 repeated_xyz(Pair pair) {
    Sampling s = sampling(copies, pair.toward);
    float largest = pair.factor != 0.0 ? largest_wavenumber(pair) : 0.0;
    vec3 xyz = vec3(0.0);
    ivec2 ends = seen_orders(s);
    for (int number = ends.x; number < ends.y; ++number) {
        vec2 order = order_at(s, number);
        float wavenumber = order.x;
        if (wavenumber > largest) {
            break; // wavenumbers grow
        }
        xyz += colour_density(wavenumber) * (order.y * wavenumber * wavenumber * power(pair, wavenumber));
    }
    return xyz * (pair.factor / s.periods);
}
