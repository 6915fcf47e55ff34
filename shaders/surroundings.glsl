// Picture of the surroundings: azimuth pi ... -pi along a row, the top row up.
layout(set = 0, binding = 7) uniform sampler2D surroundings;

// Returns the radiance from a unit vector in world space, averaged over a standard deviation `deviation` [radians].
// Linear interpolation between texels of side t, each a mean over its square, averages over a variance of t^2/4.
vec3 radiance_toward(vec3 toward, float deviation) {
    vec2 turned = mat2(frame.surroundings.x, -frame.surroundings.y, frame.surroundings.y, frame.surroundings.x) * toward.xy;
    vec2 place = vec2(0.5 - atan(turned.y, turned.x) / (2.0 * PI), acos(clamp(toward.z, -1.0, 1.0)) / PI);
    float texel = PI / float(textureSize(surroundings, 0).y);
    return textureLod(surroundings, place, max(log2(2.0 * deviation / texel), 0.0)).rgb * frame.surroundings.z;
}
