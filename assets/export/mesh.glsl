// The mesh: frame, view and footprint of a pixel as shaders/geometry.frag has them, and shadows.

uniform mat3 light_axes; // columns: to the right and upward as the light sees them, and toward the light
uniform highp sampler2DShadow shadow; // depth from the light
uniform bool shadows;

in vec3 mesh_place;
in vec3 mesh_view;
in vec3 mesh_normal;
in vec3 mesh_tangent;
in vec3 mesh_bitangent;

// Returns the part of the light that reaches the mesh here. The bias is the change of depth on the surface within a texel.
float clear_to_light(vec3 face) {
    const float STEEPEST = 30.0, TEXEL = 1.5, ROUNDING = 1e-4;
    float cosine = abs(dot(face, light_axes[2]));
    float slope = min(sqrt(max(1.0 - cosine * cosine, 0.0)) / max(cosine, 1e-6), STEEPEST);
    vec3 seen = mesh_place * light_axes;
    vec3 place = 0.5 + 0.5 * vec3(seen.xy, -seen.z);
    return texture(shadow, vec3(place.xy, place.z - ROUNDING - slope * TEXEL / float(textureSize(shadow, 0).x)));
}

// Returns the vector to the eye in the orthonormal frame of columns T, B and N. `mesh_view` holds products with interpolated axes, which are not orthonormal.
vec3 orthonormal_view(mat3 frame) {
    float z = mesh_view.z / length(mesh_normal);
    float x = (mesh_view.x - dot(mesh_tangent, frame[2]) * z) / dot(mesh_tangent, frame[0]);
    float y = mesh_view.y - dot(mesh_bitangent, frame[0]) * x - dot(mesh_bitangent, frame[2]) * z;
    return vec3(x, y / dot(mesh_bitangent, frame[1]), z);
}

Question on_mesh() {
    // Derivatives are taken before any branch.
    vec3 face = normalize(cross(dFdx(mesh_place), dFdy(mesh_place)));
    vec3 normal = normalize(mesh_normal);
    vec3 tangent = normalize(mesh_tangent - dot(mesh_tangent, normal) * normal);
    vec3 bitangent = cross(normal, tangent);
    bitangent *= dot(mesh_bitangent, bitangent) < 0.0 ? -1.0 : 1.0;
    mat3 frame = mat3(tangent, bitangent, normal);
    Question q;
    q.viewer = normalize(orthonormal_view(frame));
    q.light = to_light * frame;
    // The frame is turned about T if the back is seen.
    face *= dot(face, eye_distance * camera[2] - mesh_place) < 0.0 ? -1.0 : 1.0;
    vec3 turned = dot(mesh_normal, face) < 0.0 ? vec3(1.0, -1.0, -1.0) : vec3(1.0);
    q.viewer *= turned;
    q.light *= turned;
    q.face = face;
    q.frame = mat3(turned.x * tangent, turned.y * bitangent, turned.z * normal);
    vec2 uv = diffract_uv(q.light, q.viewer, mat3(1.0));
    q.dx = FILTER * dFdx(uv);
    q.dy = FILTER * dFdy(uv);
    float turn = FILTER * length(vec2(dFdx(q.viewer.z), dFdy(q.viewer.z)));
    q.viewer.z = q.viewer.z > 0.0 ? max(q.viewer.z, min(turn, 1.0)) : q.viewer.z;
    q.cover = 1.0;
    q.lit = clamp(q.light.z / (2.0 * sqrt(light_spread + 1e-12)), 0.0, 1.0);
    q.clear = shadows ? clear_to_light(face) : 1.0;
    widen(q);
    return q;
}
