#version 460
#extension GL_GOOGLE_include_directive : require
// Writes the G-buffer: the surface that a pixel sees, whatever the light. Shading follows in a separate pass over
// neighbouring pixels, independent of the size of triangles. The images are described in `gbuffer.glsl`.
#include "frame.glsl"

layout(set = 0, binding = 1) uniform sampler2D pigment;

layout(constant_id = 0) const bool TEXTURED = true; // true if a texture gives the pigment
layout(constant_id = 1) const int GROOVES = 0;      // orientation of the patch in the tangent frame

// Values of `GROOVES`; see src/render/grooves.rs.
const int TURNED = 1, RADIAL = 2, MAPPED = 3;

layout(set = 0, binding = 8) uniform sampler2D groove_map; // cosine and sine over (u, v)

// Outputs of `surface.vert`; `view` is not normalised.
layout(location = 0) in vec3 view;
layout(location = 1) in vec2 pigment_uv;
layout(location = 2) in vec3 world;
layout(location = 3) in vec3 world_normal;
layout(location = 4) in vec3 world_tangent;
layout(location = 5) in vec3 world_bitangent;

layout(location = 0) out vec4 facing;
layout(location = 1) out vec4 orientation;
layout(location = 2) out vec4 curving_right;
layout(location = 3) out vec4 curving_down;
layout(location = 4) out vec4 albedo; // omitted if no texture gives the pigment

// Frame of the surface in world space, orthonormal: N normalised, T made orthogonal to it.
struct Tangents {
    vec3 tangent;
    vec3 bitangent; // N x T
    vec3 normal;
    float sense;    // 1, or -1 if the mesh's B is opposite to N x T
    bool usable;    // false where the mesh's tangents cancel: T is arbitrary there
};

Tangents tangents() {
    const float DEGENERATE = 1e-3; // opposite tangents cancel
    float along_normal = length(world_normal);
    vec3 normal = along_normal > DEGENERATE ? world_normal / along_normal : vec3(0.0, 0.0, 1.0);
    vec3 tangent = world_tangent - dot(world_tangent, normal) * normal;
    float along_tangent = length(tangent);
    bool usable = along_tangent > DEGENERATE;
    if (!usable) {
        tangent = cross(normal, abs(normal.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0));
        along_tangent = length(tangent);
    }
    tangent /= along_tangent;
    vec3 bitangent = cross(normal, tangent);
    float along_bitangent = dot(world_bitangent, bitangent);
    usable = usable && min(along_normal, abs(along_bitangent)) > DEGENERATE;
    return Tangents(tangent, bitangent, normal, along_bitangent < 0.0 ? -1.0 : 1.0, usable);
}

// Returns the direction of the patch's x in components of T and B.
vec2 groove_turn() {
    if (GROOVES == TURNED) {
        return frame.grooves.xy;
    }
    vec2 turn = vec2(1.0, 0.0);
    if (GROOVES == RADIAL) {
        turn = vec2(pigment_uv.x - 0.5, 0.5 - pigment_uv.y);
    } else if (GROOVES == MAPPED) {
        turn = texture(groove_map, pigment_uv).rg;
    }
    return dot(turn, turn) > 0.0 ? normalize(turn) : vec2(1.0, 0.0);
}

// Returns the vector to the viewer in components of T, B of the mesh and N. `view` holds products with the interpolated
// vectors, which are not orthonormal: on the snake, whose normals differ by up to 0.4 across a triangle, their median
// error is 5e-3.
vec3 orthonormal_view(Tangents at) {
    if (!at.usable) {
        vec3 to_viewer = toward_viewer(world);
        return vec3(dot(at.tangent, to_viewer), at.sense * dot(at.bitangent, to_viewer), dot(at.normal, to_viewer));
    }
    float z = view.z / length(world_normal);
    float skew = dot(world_tangent, at.normal);
    float x = (view.x - skew * z) / dot(world_tangent, at.tangent);
    float y = view.y - dot(world_bitangent, at.tangent) * x - dot(world_bitangent, at.normal) * z;
    return vec3(x, y / abs(dot(world_bitangent, at.bitangent)), z);
}

// Projects stereographically from -N. Close to -N the direction is far below the horizon and its value does not matter.
vec2 projected(vec3 direction) {
    const float LEAST = 0.1;
    float size = length(direction);
    float depth = size + direction.z;
    return depth > LEAST * size ? direction.xy / depth : vec2(1.0 / LEAST, 0.0);
}

// Folds a unit vector onto the square -1 ... 1 through an octahedron.
vec2 folded(vec3 unit) {
    vec2 place = unit.xy / (abs(unit.x) + abs(unit.y) + abs(unit.z));
    vec2 side = vec2(place.x < 0.0 ? -1.0 : 1.0, place.y < 0.0 ? -1.0 : 1.0);
    return unit.z < 0.0 ? (1.0 - abs(place.yx)) * side : place;
}

// Returns the rotation from the world to right-handed orthonormal axes as modified Rodrigues parameters: the axis times
// the tangent of a quarter of the angle, of length 1 at most.
vec3 rotation_to(vec3 x, vec3 y, vec3 z) {
    vec4 q; // quaternion; its largest component is divided by, so that nothing cancels
    if (x.x + y.y + z.z > 0.0) {
        float w = 0.5 * sqrt(1.0 + x.x + y.y + z.z);
        q = vec4(vec3(z.y - y.z, x.z - z.x, y.x - x.y) / (4.0 * w), w);
    } else if (x.x > max(y.y, z.z)) {
        float a = 0.5 * sqrt(1.0 + x.x - y.y - z.z);
        q = vec4(a, vec3(x.y + y.x, x.z + z.x, z.y - y.z) / (4.0 * a));
    } else if (y.y > z.z) {
        float b = 0.5 * sqrt(1.0 + y.y - x.x - z.z);
        q = vec4((x.y + y.x) / (4.0 * b), b, vec2(y.z + z.y, x.z - z.x) / (4.0 * b));
    } else {
        float c = 0.5 * sqrt(1.0 + z.z - x.x - y.y);
        q = vec4(vec2(x.z + z.x, y.z + z.y) / (4.0 * c), c, (y.x - x.y) / (4.0 * c));
    }
    return (q.w < 0.0 ? -q.xyz : q.xyz) / (1.0 + abs(q.w));
}

// Returns the rotation that changes `axes` by these differences from pixel to pixel. Differences are within the triangle;
// beyond its edges it is extrapolated. Extrapolation behind the viewer may give NaN or infinity, and then there is no
// rotation.
vec3 rotation_of(mat3 axes, mat3 changes) {
    vec3 rotation = vec3(dot(changes[2], axes[1]), dot(changes[0], axes[2]), dot(changes[1], axes[0]));
    return any(isnan(rotation)) || any(isinf(rotation)) ? vec3(0.0) : rotation;
}

void main() {
    // Derivatives are undefined where neighbours take another branch, so that all of them are taken before any branch.
    vec3 normal = normalize(cross(dFdx(world), dFdy(world)));
    Tangents at = tangents();
    vec2 turn = groove_turn();
    vec3 x = turn.x * at.tangent + at.sense * turn.y * at.bitangent;
    vec3 y = turn.x * at.bitangent - at.sense * turn.y * at.tangent;
    vec3 z = at.normal;
    vec3 right = rotation_of(mat3(x, y, z), mat3(dFdxFine(x), dFdxFine(y), dFdxFine(z)));
    vec3 down = rotation_of(mat3(x, y, z), mat3(dFdyFine(x), dFdyFine(y), dFdyFine(z)));
    vec3 direction = orthonormal_view(at);
    direction.xy = vec2(dot(turn, direction.xy), turn.x * direction.y - turn.y * direction.x);
    normal = dot(normal, toward_viewer(world)) < 0.0 ? -normal : normal;
    // If the back of a surface is seen, as of a mesh with inward winding, the frame is turned about the patch's x.
    bool back = dot(world_normal, normal) < 0.0;
    vec3 turned = back ? vec3(1.0, -1.0, -1.0) : vec3(1.0);
    direction = normalize(turned * direction);
    // The cosine is bounded from below by its change over the filter that shading averages over: Stam's factor divides by
    // the cosine, and a single sample at a silhouette would outshine all others.
    float spread = frame.at.footprint * length(vec2(dFdxFine(direction.z), dFdyFine(direction.z)));
    direction.z = direction.z > 0.0 && spread > direction.z ? min(spread, 1.0) : direction.z;
    const float LEFT_HANDED = 4.0; // of `gbuffer.glsl`
    facing = vec4(projected(direction), folded(normal) + vec2(at.sense < 0.0 ? LEFT_HANDED : 0.0, 0.0));
    orientation = vec4(rotation_to(x, turned.y * y, turned.z * z), world.x);
    curving_right = vec4(turned * right, world.y);
    curving_down = vec4(turned * down, world.z);
    albedo = vec4(frame.base_color.rgb, 1.0);
    if (TEXTURED && frame.base_color.w > 0.0) {
        albedo.rgb *= texture(pigment, pigment_uv).rgb;
    }
}
