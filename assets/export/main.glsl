// Colour of a pixel of any view.

void main() {
    vec2 at = (2.0 * gl_FragCoord.xy - size) / size;
    vec3 background = mix(upper, lower, clamp(0.5 * dot(at - vec2(0.0, 0.25), at - vec2(0.0, 0.25)), 0.0, 1.0));
    if (view == VIEW_BACKDROP) {
        color = as_radiance ? vec4(0.0) : vec4(srgb_codes(background), 1.0);
        return;
    }
    Question q;
    if (view == VIEW_LIST) {
        q = listed(int(gl_FragCoord.x));
    } else if (view == VIEW_HEMISPHERE) {
        q = on_hemisphere(gl_FragCoord.xy);
    } else if (shape == SHAPE_MESH) {
        q = on_mesh();
    } else {
        q = on_shape(gl_FragCoord.xy);
    }
    vec3 radiance = vec3(0.0);
    if (q.cover > 0.0) {
        radiance = diffract_rgb(q.light, q.viewer, mat3(1.0), q.dx, q.dy);
    }
    if (view == VIEW_LIST) {
        color = vec4(radiance, 1.0);
        return;
    }
    // The light's irradiance is pi, so that a white matt surface that faces it has radiance 1.
    const float IRRADIANCE = 3.14159265;
    const float AMBIENT = 0.12;
    radiance *= IRRADIANCE * q.lit * q.clear;
    vec3 matt = vec3(max(q.light.z, 0.0) * q.clear);
    if (parts == 0) {
        matt += AMBIENT * (0.4 + 0.6 * max(q.viewer.z, 0.0));
    } else if (q.cover > 0.0) {
        radiance += of_surroundings(q, matt);
    }
    if (as_radiance) {
        color = vec4(radiance, q.cover);
        return;
    }
    vec3 shown = neutral(radiance * exposure + pigment * matt);
    if (view == VIEW_HEMISPHERE) {
        color = vec4(srgb_codes(shown) * q.cover, q.cover);
        return;
    }
    color = vec4(srgb_codes(mix(background, shown, q.cover)), 1.0);
}
