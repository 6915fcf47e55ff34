// Light of the surroundings, as shaders/shade.frag has it: directions that stand for parts of them, and their picture in the mirrored direction.

const int MOST_PARTS = 16;

uniform int parts;                    // directions that are drawn; 0 without surroundings
uniform vec4 part_toward[MOST_PARTS]; // unit vector toward each, and the variance of its directions
uniform vec4 part_light[MOST_PARTS];  // irradiance of a plane that faces it, and the length of the mean of its unit vectors
uniform float brightness;             // factor
uniform sampler2D surroundings;       // radiance: azimuth pi ... -pi along a row, the top row up

// Returns the radiance from a unit vector, averaged over a standard deviation [radians]: `radiance_toward` of shaders/surroundings.glsl, with +y up.
vec3 radiance_toward(vec3 toward, float deviation) {
    const float PI = 3.14159265;
    vec2 place = vec2(0.5 - atan(-toward.z, toward.x) / (2.0 * PI), acos(clamp(toward.y, -1.0, 1.0)) / PI);
    float texel = PI / float(textureSize(surroundings, 0).y);
    return textureLod(surroundings, place, max(log2(2.0 * deviation / texel), 0.0)).rgb;
}

// Returns what the specular order mirrors; nothing from below the face.
vec3 mirrored(Question q) {
    float cosine = q.viewer.z;
    vec3 toward = q.frame * vec3(-q.viewer.xy, cosine);
    DiffractPair pair = diffract_pair_of(vec3(-q.viewer.xy, cosine), q.viewer, diffract_indices);
    float place = pair.w / 2.0;
    float lobe = diffract_table_row(place, 0).a;
    vec3 xyz = diffract_table_row(place, DIFFRACT_MEAN_ROW - 1).rgb * diffract_table_factor(pair);
    vec3 radiance = radiance_toward(toward, sqrt(q.blur + lobe / max(cosine, 0.1)));
    return cosine > 1e-3 && dot(toward, q.face) > 0.0 ? DIFFRACT_LINEAR_SRGB_FROM_XYZ * xyz * radiance / cosine : vec3(0.0);
}

// Returns the mean of max(cos, 0) over the directions of a part: `mean_cosine` of src/scene/incident.rs.
float mean_cosine(float cosine, float mean) {
    float whole = mean * cosine, along = (1.0 - mean) * (1.0 - mean);
    float across = 1.5 * (1.0 - mean * mean - along / 3.0);
    float width = sqrt(max(along * cosine * cosine + across * (1.0 - cosine * cosine), 0.0)); // half of it
    return abs(whole) >= width ? max(whole, 0.0) : (whole + width) * (whole + width) / (4.0 * width);
}

// Returns the radiance that the surroundings give, and adds their irradiance over pi.
vec3 of_surroundings(Question q, inout vec3 irradiance) {
    const float PI = 3.14159265, HORIZON = 1e-3;
    vec3 sum = mirrored(q);
    for (int i = 0; i < parts; ++i) {
        vec3 light = part_toward[i].xyz * q.frame;
        irradiance += part_light[i].rgb * mean_cosine(light.z, part_light[i].a) * brightness / PI;
        if (light.z > HORIZON) {
            DiffractPair pair = diffract_pair_of(light, q.viewer, diffract_indices);
            sum += DIFFRACT_LINEAR_SRGB_FROM_XYZ * diffract_table_round(pair, part_toward[i].w + q.blur) * part_light[i].rgb;
        }
    }
    return sum * brightness;
}
