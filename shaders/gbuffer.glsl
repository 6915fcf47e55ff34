// G-buffer: the surface that `geometry.frag` found at a pixel, whatever the light.

// Direction to the viewer in the frame of the patch, projected stereographically from -N (xy). Normal of the triangle in
// the world, folded through an octahedron (zw; z plus LEFT_HANDED if the frame of the patch is left-handed).
layout(set = 0, binding = 2) uniform sampler2D facing;
// Rotation from the world to the frame of the patch, by modified Rodrigues parameters (xyz), and x of the position (w).
layout(set = 0, binding = 3) uniform sampler2D orientation;
// Rotation of the frame from pixel to pixel, in the frame (xyz), to the right and downward; y and z of the position (w).
layout(set = 0, binding = 4) uniform sampler2D curving_right;
layout(set = 0, binding = 5) uniform sampler2D curving_down;
layout(set = 0, binding = 9) uniform sampler2D albedos; // textured pigment, linear sRGB

// Clear value of `facing`: outside the range of the projection.
const float UNCOVERED = 100.0;
const float NEARLY_UNCOVERED = 50.0;

const float LEFT_HANDED = 4.0;
const float NEARLY_LEFT_HANDED = 2.0;

// Surface at a pixel. A left-handed frame is stored as the right-handed one with the opposite y; `sense` changes y of
// vectors between the two.
struct SurfacePoint {
    vec3 to_view;       // unit vector in the frame of the patch
    vec3 position;      // in the world
    vec3 face;          // normal of the triangle toward the viewer, in the world
    vec3 rotation;      // from the world to the right-handed frame
    float sense;        // -1 if the frame of the patch is left-handed, otherwise 1
    vec3 curving_right; // rotation of the right-handed frame to the next pixel to the right, in that frame
    vec3 curving_down;  // to the next pixel below
    vec2 toward;        // side of the neighbour in the quad of 2 x 2 pixels: 1 or -1, to the right and downward
};

vec3 unprojected(vec2 s) {
    float k = 2.0 / (1.0 + dot(s, s));
    return vec3(k * s, k - 1.0);
}

vec3 unfolded(vec2 place) {
    float z = 1.0 - abs(place.x) - abs(place.y);
    vec2 side = vec2(place.x < 0.0 ? -1.0 : 1.0, place.y < 0.0 ? -1.0 : 1.0);
    return normalize(vec3(z < 0.0 ? (1.0 - abs(place.yx)) * side : place, z));
}

// Rotates a vector by modified Rodrigues parameters.
vec3 rotated(vec3 rotation, vec3 v) {
    float square = dot(rotation, rotation), whole = 1.0 + square;
    vec3 once = cross(rotation, v);
    return v + (4.0 * (1.0 - square) * once + 8.0 * cross(rotation, once)) / (whole * whole);
}

bool covered(vec4 stored) {
    return stored.x < NEARLY_UNCOVERED;
}

SurfacePoint surface_at(ivec2 pixel) {
    vec4 seen = texelFetch(facing, pixel, 0), axes = texelFetch(orientation, pixel, 0);
    vec4 right = texelFetch(curving_right, pixel, 0), down = texelFetch(curving_down, pixel, 0);
    bool left_handed = seen.z > NEARLY_LEFT_HANDED;
    SurfacePoint at;
    at.to_view = unprojected(seen.xy);
    at.position = vec3(axes.w, right.w, down.w);
    at.face = unfolded(seen.zw - vec2(left_handed ? LEFT_HANDED : 0.0, 0.0));
    at.rotation = axes.xyz;
    at.sense = left_handed ? -1.0 : 1.0;
    at.curving_right = right.xyz;
    at.curving_down = down.xyz;
    at.toward = vec2(1 - 2 * (pixel & 1));
    return at;
}

// Returns the difference between a pixel and its neighbour in the quad, on the side `toward`, of a direction in the
// right-handed frame: `here`, and `there` in the world at the neighbour. The frame rotates by `curving` from pixel to pixel.
vec3 difference(SurfacePoint at, vec3 curving, float toward, vec3 here, vec3 there) {
    vec3 same = rotated(at.rotation, there), turn = toward * cross(curving, same);
    return toward * (same + turn + 0.5 * toward * cross(curving, turn) - here);
}

// No branch: see `widened` in light.glsl.
vec3 albedo_of(ivec2 pixel) {
    return mix(frame.base_color.rgb, texelFetch(albedos, pixel, 0).rgb, bvec3(frame.base_color.w > 0.0));
}

// Returns how far the point moves on the plane of this normal from a pixel to the next, to the right (column 0) and
// downward (column 1): a displacement d has dot(normal, d) = 0 and moves the picture by one pixel along one axis.
mat2x3 moves_on_plane(SurfacePoint at, vec3 normal) {
    mat4 rows = transpose(frame.clip_from_world);
    vec4 point = vec4(at.position, 1.0);
    float w = dot(rows[3], point);
    vec3 x = rows[0].xyz - dot(rows[0], point) / w * rows[3].xyz;
    vec3 y = rows[1].xyz - dot(rows[1], point) / w * rows[3].xyz;
    vec3 along_x = cross(y, normal), along_y = cross(x, normal);
    vec2 pixel = w * frame.grooves.zw;
    return mat2x3(along_x * (pixel.x / dot(x, along_x)), along_y * (pixel.y / dot(y, along_y)));
}

// Returns the differences of the direction to the viewer in the right-handed frame, to the right and downward. On the
// plane that is parallel to the picture, the viewing ray moves by the same vector from each pixel to the next.
mat2x3 view_differences(SurfacePoint at) {
    vec3 to_viewer = toward_viewer(at.position);
    mat2x3 moves = frame.viewer.w * moves_on_plane(at, transpose(frame.clip_from_world)[2].xyz);
    vec3 here = rotated(at.rotation, normalize(to_viewer)); // whose cosine has no lower bound
    return mat2x3(
        difference(at, at.curving_right, at.toward.x, here, normalize(to_viewer - at.toward.x * moves[0])),
        difference(at, at.curving_down, at.toward.y, here, normalize(to_viewer - at.toward.y * moves[1])));
}
