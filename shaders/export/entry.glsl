// Returns (u, v) of unit vectors from the surface to the light and to the viewer. The columns of `frame` are tangent T, bitangent B and normal N.
vec2 uv(vec3 light, vec3 viewer, mat3 frame) {
    return -((light + viewer) * frame).xy;
}

// Returns linear sRGB of f cos(theta_light) [1/sr], to be multiplied by the irradiance on a plane that faces the light. Components may be negative: colours
// of diffraction leave the gamut of sRGB.
//
// light, viewer: unit vectors from the surface. frame: columns T, B and N, orthonormal.
// dx, dy: change of `uv` from the pixel to its right and to its lower neighbour, times the standard deviation of the pixel filter, usually 0.5; 0 for a point.
vec3 rgb(vec3 light, vec3 viewer, mat3 frame, vec2 dx, vec2 dy) {
    Pair pair = pair_of(light * frame, viewer * frame, indices);
    Footprint footprint = Footprint(dx, dy);
    vec3 xyz = table_scattered(pair, footprint) + table_specular(pair, footprint);
    return pair.factor.y > 0.0 ? LINEAR_SRGB_FROM_XYZ * xyz : vec3(0.0);
}
