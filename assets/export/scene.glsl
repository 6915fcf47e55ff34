// Pictures of the page: a shape under one light, the hemisphere of viewers, or the colours of listed directions. The page puts material.es.glsl and
// color.glsl before it, and mesh.glsl, surroundings.glsl and main.glsl behind it.

const int SHAPE_SPHERE = 0, SHAPE_DISC = 1, SHAPE_PLATE = 2, SHAPE_MESH = 3;
const int VIEW_SHAPE = 0, VIEW_HEMISPHERE = 1, VIEW_LIST = 2, VIEW_BACKDROP = 4;

uniform int view;
uniform int shape;
uniform vec2 size;         // of the picture [pixels]
uniform mat3 camera;       // columns: to the right, upward, and back to the eye
uniform float eye_distance;
uniform float focal;       // focal length over half the shorter side of the picture
uniform vec3 to_light;     // unit vector
uniform float light_spread; // variance of the directions of the light
uniform float exposure;    // factor
uniform float pigment;     // displayed albedo of a matt layer below, which is no part of the material
uniform vec3 upper, lower; // of the background, linear
uniform bool as_radiance;  // linear numbers instead of a picture
uniform highp sampler2D list; // a direction in each column: light, viewer, footprint

out vec4 color;

struct Spot {
    vec3 place;
    mat3 frame;  // tangent, bitangent, normal
    float outside; // distance from the edge, negative within
};

vec3 ray(vec2 pixel) {
    vec2 at = (2.0 * pixel - size) / min(size.x, size.y);
    return normalize(camera * vec3(at, -focal));
}

Spot sphere(vec3 eye, vec3 direction) {
    float nearest = -dot(eye, direction);
    vec3 beside = eye + nearest * direction;
    float miss = length(beside);
    // Beside the sphere, its edge.
    vec3 normal = normalize(eye + (nearest - sqrt(max(1.0 - miss * miss, 0.0))) * direction);
    // The frame of the z axis, turned to the normal by the shortest way (Frisvad, Building an Orthonormal Basis from a 3D Unit Vector, 2012).
    float share = 1.0 / max(1.0 + normal.z, 1e-4), twist = -normal.x * normal.y * share;
    vec3 tangent = vec3(1.0 - normal.x * normal.x * share, twist, -normal.x);
    vec3 bitangent = vec3(twist, 1.0 - normal.y * normal.y * share, -normal.y);
    return Spot(normal, mat3(tangent, bitangent, normal), miss - 1.0);
}

Spot flat_spot(vec3 eye, vec3 direction) {
    const float HOLE = 0.22, HALF_SIDE = 0.86;
    float depth = direction.z < -1e-4 ? -eye.z / direction.z : 1e4;
    vec3 place = vec3((eye + depth * direction).xy, 0.0);
    vec3 normal = vec3(0.0, 0.0, 1.0);
    if (shape == SHAPE_PLATE) {
        vec2 over = abs(place.xy) - HALF_SIDE;
        return Spot(place, mat3(1.0), max(over.x, over.y));
    }
    float radius = length(place.xy);
    vec3 outward = vec3(place.xy / max(radius, 1e-6), 0.0);
    return Spot(place, mat3(outward, cross(normal, outward), normal), max(radius - 1.0, HOLE - radius));
}

Spot spot_at(vec2 pixel) {
    vec3 eye = eye_distance * camera[2];
    vec3 direction = ray(pixel);
    if (shape == SHAPE_SPHERE) {
        return sphere(eye, direction);
    }
    return flat_spot(eye, direction);
}

vec3 viewer_of(Spot spot) {
    return normalize(eye_distance * camera[2] - spot.place);
}

// Directions and footprint of a pixel.
struct Question {
    vec3 light;
    vec3 viewer;
    vec2 dx;
    vec2 dy;
    float cover; // part of the pixel that the shape covers
    float lit;   // part of the light above the horizon
    float clear; // part of the light that nothing shadows
    mat3 frame;  // columns tangent, bitangent and normal, in which the directions are
    vec3 face;   // normal of the face, toward the viewer
    float blur;  // variance of (u, v) along an axis over the pixel
};

// Adds to the covariance of the footprint that of the light, whose directions vary by `light_spread` across it.
void widen(inout Question q) {
    q.blur = 0.5 * (dot(q.dx, q.dx) + dot(q.dy, q.dy));
    float uu = q.dx.x * q.dx.x + q.dy.x * q.dy.x + light_spread * (1.0 - q.light.x * q.light.x);
    float uv = q.dx.x * q.dx.y + q.dy.x * q.dy.y - light_spread * q.light.x * q.light.y;
    float vv = q.dx.y * q.dx.y + q.dy.y * q.dy.y + light_spread * (1.0 - q.light.y * q.light.y);
    // Cholesky's root.
    float u = sqrt(max(uu, 1e-14)), v = uv / u;
    q.dx = vec2(u, v);
    q.dy = vec2(0.0, sqrt(max(vv - v * v, 0.0)));
}

// Standard deviation of the pixel filter [pixels].
const float FILTER = 0.5;

Question on_shape(vec2 pixel) {
    Spot here = spot_at(pixel), right = spot_at(pixel + vec2(1.0, 0.0)), above = spot_at(pixel + vec2(0.0, 1.0));
    Question q;
    q.frame = here.frame;
    q.face = here.frame[2];
    q.light = to_light * here.frame;
    q.viewer = viewer_of(here) * here.frame;
    vec3 to_right = viewer_of(right) * right.frame, to_above = viewer_of(above) * above.frame;
    vec2 uv = diffract_uv(q.light, q.viewer, mat3(1.0));
    q.dx = FILTER * (diffract_uv(to_light * right.frame, to_right, mat3(1.0)) - uv);
    q.dy = FILTER * (diffract_uv(to_light * above.frame, to_above, mat3(1.0)) - uv);
    // At a silhouette the cosine is at least its change within the pixel, because the pixel averages over the visible part.
    float turn = FILTER * length(vec2(to_right.z - q.viewer.z, to_above.z - q.viewer.z));
    q.viewer.z = max(q.viewer.z, min(turn, 1.0));
    float change = length(vec2(right.outside - here.outside, above.outside - here.outside));
    float sink = FILTER * length(vec2(dot(to_light, right.frame[2]) - q.light.z, dot(to_light, above.frame[2]) - q.light.z));
    q.lit = clamp(q.light.z / (2.0 * sqrt(light_spread + sink * sink)), 0.0, 1.0);
    q.cover = clamp(0.5 - here.outside / max(change, 1e-6), 0.0, 1.0);
    q.clear = 1.0;
    widen(q);
    return q;
}

Question on_hemisphere(vec2 pixel) {
    vec2 at = (2.0 * pixel - size) / size;
    float r2 = dot(at, at), step = 2.0 / size.x;
    Question q;
    q.frame = mat3(1.0);
    q.face = vec3(0.0, 0.0, 1.0);
    q.light = to_light;
    q.viewer = vec3(at, sqrt(max(1.0 - r2, 0.0)));
    q.viewer.z = max(q.viewer.z, sqrt(FILTER * step));
    q.dx = vec2(FILTER * step, 0.0);
    q.dy = vec2(0.0, FILTER * step);
    q.cover = clamp((1.0 - sqrt(r2)) / step + 0.5, 0.0, 1.0);
    q.lit = 1.0;
    q.clear = 1.0;
    widen(q);
    return q;
}

Question listed(int column) {
    Question q;
    q.frame = mat3(1.0);
    q.face = vec3(0.0, 0.0, 1.0);
    q.blur = 0.0;
    q.light = texelFetch(list, ivec2(column, 0), 0).xyz;
    q.viewer = texelFetch(list, ivec2(column, 1), 0).xyz;
    vec4 footprint = texelFetch(list, ivec2(column, 2), 0);
    q.dx = footprint.xy;
    q.dy = footprint.zw;
    q.cover = 1.0;
    q.lit = 1.0;
    q.clear = 1.0;
    return q;
}
